"""The paper's arithmetic, recomputed from its printed means."""

import pytest
from torquebench.evaluation.claims import read_book
from torquebench.evaluation.paper import equivalent_lag, reductions, slow_reduction, water_over_sand

RECOMPUTED = (20.56, 12.10, 18.94, 9.64, 66.89, 34.06, 65.49, 42.52)


@pytest.mark.parametrize(("found", "expected"), list(zip(reductions(), RECOMPUTED, strict=True)))
def test_a_percentage_follows_from_its_means(found, expected):
    """Against figures worked out by hand."""
    assert found.recomputed == pytest.approx(expected, abs=5e-3)


def test_one_percentage_does_not_follow_from_its_means():
    """Obs. 2, water, orientation: 39.4 % is printed, 42.5 % comes out; all others agree within 0.06 points."""
    assert [found.place for found in reductions() if not found.agrees] == ["Obs. 2, water, orientation"]
    assert pytest.approx(39.4, abs=0.06) == 100.0 * (1.0 - 0.338 / 0.558)


def test_every_printed_percentage_is_that_of_its_claim():
    """Two lists of one number would drift apart."""
    claims = {claim.id: claim.printed for claim in read_book().claim}
    names = ("C3", "C4", "C5", "C6", "C9", "C10", "C11", "C12")
    assert [claims[name] for name in names] == [found.printed for found in reductions()]


def test_water_is_the_harder_load_for_one_controller_only():
    """The factory's printed means are smaller with water, against what Obs. 5 says."""
    expected = {
        "factory, position": 0.988,
        "factory, orientation": 0.992,
        "CBMC-V3, position": 1.008,
        "CBMC-V3, orientation": 1.020,
    }
    assert water_over_sand() == pytest.approx(expected, abs=5e-4)


@pytest.mark.parametrize(("error", "lag"), [(0.018, 55.9), (0.01779, 55.2), (0.0143, 44.4), (0.01442, 44.8)])
def test_the_printed_errors_are_lags(error, lag):
    """1.8 cm at the mean speed of the paths is 56 ms."""
    assert 1e3 * equivalent_lag(error) == pytest.approx(lag, abs=0.05)


@pytest.mark.parametrize(
    ("overall", "fast", "text", "caption"),
    [(20.56, 29.4, 11.9, -3.6), (12.10, 17.5, 6.8, -2.7), (18.94, 28.5, 9.5, -7.2), (9.64, 14.1, 5.3, -2.6)],
)
def test_the_text_is_right_about_which_group_is_fast(overall, fast, text, caption):
    """With five fast paths the slow ones would have become worse, against what is claimed of both groups."""
    found = [100.0 * slow_reduction(overall / 100.0, fast / 100.0, share) for share in (3.0 / 8.0, 5.0 / 8.0)]
    assert found == pytest.approx([text, caption], abs=0.1)
    assert found[0] > 0.0 > found[1]


def test_the_reductions_of_both_groups_make_up_that_of_all():
    """The formula against its own meaning: weights of errors times reductions add up."""
    slow = slow_reduction(0.2, 0.3, 3.0 / 8.0, 2.0)
    assert (3.0 * 2.0 * 0.3 + 5.0 * slow) / (3.0 * 2.0 + 5.0) == pytest.approx(0.2)
