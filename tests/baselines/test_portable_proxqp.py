"""ProxQP's build: one answer, wherever in memory a program lies and whatever a processor can do."""

import subprocess
import sys

import numpy as np
import pytest
from torquebench.baselines.quadratic_program import QuadraticProgram

VARIABLES, ROWS = 14, 20


def programs(rng):
    """Return programs with a few dozen numbers each, of which some rows bind."""
    for _ in range(40):
        root = rng.normal(size=(VARIABLES, VARIABLES))
        most = 0.3 * np.abs(rng.normal(size=ROWS))
        yield (
            root @ root.T + 0.1 * np.eye(VARIABLES),
            rng.normal(size=VARIABLES),
            rng.normal(size=(ROWS, VARIABLES)),
            -most,
            most,
        )


def test_an_answer_does_not_depend_on_its_place_in_memory():
    """With wide vector instructions every second workspace gives other last digits: no run repeats to the bit."""
    listed, rng = list(programs(np.random.default_rng(0))), np.random.default_rng(1)
    answers = set()
    for _ in range(12):
        between = [np.zeros(size) for size in rng.integers(1, 3000, rng.integers(0, 50))]
        program = QuadraticProgram(VARIABLES, ROWS, tolerance=1e-8, outer=50, inner=200)
        found = [program.solve(*data) for data in listed]
        assert between is not None and all(answer is not None for answer in found)
        answers.add(np.array(found).tobytes())
    assert len(answers) == 1


@pytest.mark.parametrize("before", ["", "import proxsuite; "])
def test_whoever_loads_proxsuite_first_decides_and_nobody_crashes(before):
    """A process cannot hold two builds: a user's own import before ours is respected, one after it gets ours."""
    code = (
        f"{before}from torquebench.baselines import portable_proxqp; import proxsuite, sys; "
        "assert proxsuite.proxqp is portable_proxqp.proxqp; "
        "print(proxsuite.proxqp.__name__, 'proxsuite.instructionset' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    if not before:
        assert done.stdout.split() == ["proxsuite.proxsuite_pywrap.proxqp", "False"]


def test_this_process_has_the_build_without_wide_instructions():
    """Nothing that the library imports loads another one first."""
    import proxsuite

    assert proxsuite.proxqp.__name__ == "proxsuite.proxsuite_pywrap.proxqp"
