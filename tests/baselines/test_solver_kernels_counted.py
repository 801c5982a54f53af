"""The formulas of a plan against its kernels: the same code runs on numbers that count what is done to them."""

from collections import Counter
from typing import ClassVar

import numpy as np
from torquebench.baselines.mpc_horizon import Horizon
from torquebench.baselines.mpc_kernels import roll_out, torque_columns, tracking_gradient
from torquebench.baselines.mpc_tool_kernels import add_tool_cost, factorise, unwhiten, whiten
from torquebench.baselines.operation_graph import count_graph
from torquebench.baselines.solver_costs import _condensing, _tool_cost, factorisation
from torquebench.baselines.symbolic_dynamics import tool_function

JOINTS, BLOCKS = 3, (1, 1, 2)
HORIZON = Horizon.of(BLOCKS, 0.02)
KNOTS, COUNT = HORIZON.selection.shape
VARIABLES, ROWS = COUNT * JOINTS, KNOTS * JOINTS


class Counting(float):
    """A number that notes every operation on it; zero and one are numbers like any other."""

    done: ClassVar[Counter] = Counter()

    def _note(kind, name):
        def operate(self, other):
            Counting.done[kind] += 1
            return Counting(getattr(float, name)(float(self), float(other)))

        return operate

    __add__, __radd__ = _note("additions", "__add__"), _note("additions", "__radd__")
    __sub__, __rsub__ = _note("additions", "__sub__"), _note("additions", "__rsub__")
    __mul__, __rmul__ = _note("products", "__mul__"), _note("products", "__rmul__")
    __truediv__, __rtruediv__ = _note("divisions", "__truediv__"), _note("divisions", "__rtruediv__")


def counting(*shape):
    """Return an array of counting numbers."""
    return counted(np.random.default_rng(1).uniform(0.5, 1.5, shape))


def counted(array):
    """Return an array's numbers as counting ones."""
    found = np.empty(array.shape, dtype=object)
    found.ravel()[:] = [Counting(value) for value in array.ravel()]
    return found


def operations(kernel, *arguments):
    """Run a kernel's Python and return what it did."""
    Counting.done = Counter()
    kernel.py_func(*arguments)
    return Counting.done


def basis():
    return [counted(matrix) for matrix in (HORIZON.position, HORIZON.velocity, HORIZON.selection)]


def test_the_counting_numbers_count():
    """The check of the check: two products, a sum, a quotient."""

    class Kernel:
        @staticmethod
        def py_func(a, b, out):
            out[0] = (a[0] * b[0] + 2.0 * a[1]) / b[1]

    assert operations(Kernel, counting(2), counting(2), counting(1)) == Counter(products=2, additions=1, divisions=1)


def test_the_products_of_condensing_are_those_of_its_kernels():
    """Two roll-outs, a gradient, torque rows; beside them a check of the rows and the change of unknowns."""
    state = [counting(KNOTS + 1, JOINTS), counting(KNOTS + 1, JOINTS), counting(KNOTS, JOINTS)]
    rolled = operations(roll_out, counting(2, JOINTS), counting(COUNT, JOINTS), *basis(), 0.02, *state)
    # Start and drift of every knot are no part of the condensed matrices.
    rolled["products"] -= (KNOTS + 1) * JOINTS
    slope = operations(tracking_gradient, *state, counting(KNOTS, 2, 2), *basis(), counting(VARIABLES))
    rows = operations(torque_columns, counting(KNOTS, 3 * JOINTS, JOINTS), *basis(), counting(VARIABLES, ROWS))
    beside = ROWS * VARIABLES + COUNT * COUNT * JOINTS
    assert _condensing(JOINTS, KNOTS, COUNT).macs == (
        2 * rolled["products"] + slope["products"] + rows["products"] + beside
    )


def test_the_factor_of_a_plan_costs_what_its_kernel_does():
    """(v^3 - v) / 6 products and a division for each entry of the triangle; the pivots' roots come on top."""
    root = np.random.default_rng(0).normal(size=(VARIABLES, VARIABLES))
    done = operations(factorise, counted(root @ root.T + np.eye(VARIABLES)))
    formula = factorisation(VARIABLES)
    assert (done["products"], done["divisions"]) == (formula.macs, formula.divisions)


def test_the_tools_cost_adds_what_its_kernels_do(bench):
    """Slope and curvature of every knot, blocks that have begun, and rows, gradient and solution in whitened terms."""
    factor, position = counted(np.triu(np.ones((VARIABLES, VARIABLES)))), counted(HORIZON.position)
    slopes, curvatures = counting(KNOTS, JOINTS), counting(KNOTS, JOINTS, JOINTS)
    square = counting(VARIABLES, VARIABLES)
    white = operations(whiten, factor, counting(VARIABLES, ROWS))
    white += operations(whiten, factor, counting(VARIABLES, 1)) + operations(unwhiten, factor, counting(VARIABLES))
    added = operations(add_tool_cost, slopes, curvatures, position, counting(VARIABLES), square)
    # The product of two shares, once for a pair of blocks, is left out.
    pairs = sum(COUNT - b for k in range(KNOTS) for b in range(COUNT) if HORIZON.position[k + 1, b] != 0.0)
    sloped = KNOTS * (12 * JOINTS + 12 * JOINTS * (JOINTS + 1) // 2)
    robot, factored = bench("planar").model, factorisation(VARIABLES)
    formula, model = _tool_cost(robot, HORIZON), count_graph(tool_function(robot)).operations.times(KNOTS)
    assert robot.n == JOINTS
    assert formula.macs - model.macs - factored.macs == white["products"] + added["products"] - pairs + sloped
    assert formula.divisions - model.divisions - factored.divisions == white["divisions"]
