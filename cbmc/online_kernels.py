"""Compiled forward pass, backward pass and descent of the two networks that learn online.

A network of two layers lives in one vector of float64, its counters in one of int64: a compiled call spends more on
unpacking many arrays than on this arithmetic. ``at`` holds the sizes and where each block begins.
"""

import math

import numba
import numpy as np

# Entries of ``at``: sizes, then beginnings of the blocks of ``memory``. The first four blocks are the parameters.
INPUTS, HIDDEN, OUTPUTS, STEPS = 0, 1, 2, 3
W1, B1, W2, B2, MOMENTA, GRADIENT, X, U, OUTPUT_GRADIENT, TRACE, CHARGED, END = range(4, 16)

# Entries of ``constants``; the weights c_t of the output neurons' leak follow.
TAU, RESET, FIRE, SLOPE, OUTPUT_RESET, LEARNING_RATE, MOMENTUM, DECAY, BIASES, LEAK_SUM, LEAK = range(11)

# Entries of ``tally``, cumulative; the hidden layer's spikes of the last call follow.
CALLS, UPDATES, SKIPPED, SPIKES, PAIRS, LAST = range(6)


def places(inputs: int, hidden: int, outputs: int, steps: int) -> np.ndarray:
    """Return ``at`` for a network of these sizes and a window of so many steps."""
    parameters = [inputs * hidden, hidden, hidden * outputs, outputs]
    total = sum(parameters)
    blocks = [*parameters, total, total, inputs, outputs, outputs, hidden, hidden * steps]
    return np.array([inputs, hidden, outputs, steps, *np.cumsum([0, *blocks])], dtype=np.int64)


@numba.njit(cache=True)
def forward(memory, at, constants, tally):  # type: ignore[no-untyped-def]
    """Run one window of constant input X; fills the potentials U and what the backward pass needs.

    The output layer is linear in the hidden spikes, so it is evaluated once, on their trace z = sum_t c_t s_t.
    """
    inputs, hidden, outputs, steps = at[INPUTS], at[HIDDEN], at[OUTPUTS], at[STEPS]
    tau, reset, fire = constants[TAU], constants[RESET], constants[FIRE]
    tally[CALLS] += 1
    for h in range(hidden):
        current = 0.0
        for i in range(inputs):
            current += memory[at[W1] + h * inputs + i] * memory[at[X] + i]
        current += memory[at[B1] + h]
        potential, trace, fired_before = reset, 0.0, False
        tally[LAST + h] = 0
        for t in range(steps):
            charged = potential + (current - (potential - reset)) / tau
            memory[at[CHARGED] + h * steps + t] = charged
            fired = charged >= fire
            potential = reset if fired else charged
            if fired:
                trace += constants[LEAK + t]
                tally[LAST + h] += 1
                tally[PAIRS] += fired_before
            fired_before = fired
        memory[at[TRACE] + h] = trace
        tally[SPIKES] += tally[LAST + h]
    for o in range(outputs):
        potential = constants[OUTPUT_RESET] + memory[at[B2] + o] * constants[LEAK_SUM]
        for h in range(hidden):
            potential += memory[at[W2] + o * hidden + h] * memory[at[TRACE] + h]
        memory[at[U] + o] = potential


@numba.njit(cache=True)
def current_gradient(memory, at, constants, h, trace_gradient):  # type: ignore[no-untyped-def]
    """Return the sum over the window of dL/dI of one hidden neuron, resets included (``neuron.window_gradient``)."""
    tau, reset, fire, slope = constants[TAU], constants[RESET], constants[FIRE], constants[SLOPE]
    total, carried = 0.0, 0.0
    for t in range(at[STEPS] - 1, -1, -1):
        charged = memory[at[CHARGED] + h * at[STEPS] + t]
        decay = math.exp(-abs(slope * (charged - fire)))
        derivative = slope * decay / ((1.0 + decay) * (1.0 + decay))
        through_spike = constants[LEAK + t] * trace_gradient + carried * (reset - charged)
        through_charge = through_spike * derivative + (0.0 if charged >= fire else carried)
        total += through_charge / tau
        carried = through_charge * (1.0 - 1.0 / tau)
    return total


@numba.njit(cache=True)
def backward(memory, at, constants):  # type: ignore[no-untyped-def]
    """Turn dL/dU, in OUTPUT_GRADIENT, into the gradient of every parameter for the last window."""
    inputs, hidden, outputs = at[INPUTS], at[HIDDEN], at[OUTPUTS]
    gradient, upstream, biases = at[GRADIENT], at[OUTPUT_GRADIENT], constants[BIASES]
    for h in range(hidden):
        trace_gradient = 0.0
        for o in range(outputs):
            trace_gradient += memory[upstream + o] * memory[at[W2] + o * hidden + h]
        total = current_gradient(memory, at, constants, h, trace_gradient)
        memory[gradient + at[B1] + h] = total * biases
        for i in range(inputs):
            memory[gradient + at[W1] + h * inputs + i] = total * memory[at[X] + i]
    for o in range(outputs):
        memory[gradient + at[B2] + o] = memory[upstream + o] * constants[LEAK_SUM] * biases
        for h in range(hidden):
            memory[gradient + at[W2] + o * hidden + h] = memory[upstream + o] * memory[at[TRACE] + h]


@numba.njit(cache=True)
def descend(memory, at, constants, tally):  # type: ignore[no-untyped-def]
    """Take one step of stochastic gradient descent, or none at all where it would not end in finite numbers.

    Momentum and decay as in torch: the decay joins the gradient before the momentum, for biases too.
    """
    rate, momentum, decay = constants[LEARNING_RATE], constants[MOMENTUM], constants[DECAY]
    count, momenta, gradient = at[MOMENTA], at[MOMENTA], at[GRADIENT]
    for k in range(count):
        memory[gradient + k] += decay * memory[k]
        if not math.isfinite(memory[k] - rate * (momentum * memory[momenta + k] + memory[gradient + k])):
            tally[SKIPPED] += 1
            return
    tally[UPDATES] += 1
    for k in range(count):
        memory[momenta + k] = momentum * memory[momenta + k] + memory[gradient + k]
        memory[k] -= rate * memory[momenta + k]


@numba.njit(cache=True)
def update(memory, at, constants, tally):  # type: ignore[no-untyped-def]
    """Learn from dL/dU of the last window: backward pass, then one step of descent."""
    backward(memory, at, constants)
    descend(memory, at, constants, tally)
