"""Accuracies: their forms, their canonical text, their draws."""

import pytest
from scipy import stats

from swarmcensus.worlds import distributions, sensors


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.675, "0.675"),
        (1, "1.0"),
        ("0.5", "0.5"),
        ("U(0.525, 0.975)", "U(0.525,0.975)"),
        (" N ( 0.75 , 0.1 ) ", "N(0.75,0.1)"),
        ({"black": 0.9, "white": 0.6}, "black=0.9 white=0.6"),
        ({"black": "U(0.5,1)", "white": 1}, "black=U(0.5,1.0) white=1.0"),
    ],
)
def test_forms(value, text):
    accuracy = sensors.parse_accuracy(value)
    assert str(accuracy) == text
    assert sensors.parse_accuracy(accuracy) is accuracy
    assert sensors.parse_accuracy(accuracy.form) == accuracy


@pytest.mark.parametrize(("value", "text"), [(0.1, "error=0.1"), ("U(-1, 1)", "error=U(-1.0,1.0)"), (-1, "error=-1.0")])
def test_forms_of_errors(value, text):
    assumed = sensors.parse_assumed({"error": value})
    assert str(assumed) == text
    assert sensors.parse_assumed(assumed) is assumed
    assert sensors.parse_assumed(assumed.form) == assumed
    assert sensors.parse_assumed(0.7) == sensors.parse_accuracy(0.7)


@pytest.mark.parametrize("value", [1.1, -1.1, "U(0.5,0.2)", "U(-0.5,1.2)", "N(0,0)", "U(-2,0)", True, None, {}])
def test_what_is_no_error(value):
    with pytest.raises(ValueError, match=r"error|accuracy|needs"):
        sensors.parse_assumed({"error": value})


@pytest.mark.parametrize(
    "value",
    [1.1, -0.1, "1.1", "U(0.9,0.6)", "U(0.5,1.5)", "N(0.5,0)", "N(2,1)", "N(0.5,inf)", "X(1,2)", "nan", float("nan"),
     None, True, [0.5], {"black": 0.9}, {"black": 0.9, "white": 0.6, "grey": 0.1}, "U(a,b)"],
)  # fmt: skip
def test_what_is_refused(value):
    with pytest.raises(ValueError, match=r"accuracy|needs"):
        sensors.parse_accuracy(value)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("U(0.5)", r"U\(lo, hi\) needs 2 numbers, not 1"),
        ("N(0.5, 0.1, 0.2)", r"N\(mean, sd\) needs 2 numbers, not 3"),
        ("N()", r"N\(mean, sd\) needs 2 numbers, not 0"),
        ("U(0.9, 0.6)", r"U\(lo, hi\): it needs lo <= hi"),
        ("N(0.5, 0)", r"N\(mean, sd\): it needs sd > 0"),
        ("U(0.5, 1.5)", r"a sensor accuracy lies in \[0, 1\], and U\(0.5,1.5\) gives 1.5"),
        ("n(0.5, 0.1)", "did you mean 'N'. a sensor accuracy is a number"),
        ("unifrom(0.5, 0.6)", "did you mean 'uniform'. a sensor accuracy is"),
    ],
)
def test_a_wrong_distribution_is_refused(value, said):
    with pytest.raises(ValueError, match=said):
        sensors.parse_accuracy(value)


def test_a_spread_is_a_file_with_the_papers_letter():
    assert distributions.PLUGINS.shipped == ("measured", "normal", "uniform")
    assert sensors.parse_accuracy("uniform(0.5, 0.9)") == sensors.parse_accuracy("U(0.5,0.9)")
    assert not sensors.parse_accuracy({"black": "U(0.5, 0.9)", "white": "N(0.7, 0.1)"}).edition


def test_blindness():
    assert sensors.parse_accuracy(0.5).is_blind
    assert sensors.parse_accuracy({"black": 0.7, "white": 0.3}).is_blind
    assert not sensors.parse_accuracy(0.51).is_blind
    assert not sensors.parse_accuracy("U(0.5,0.5)").is_blind


@pytest.mark.parametrize(("mean", "sd"), [(0.75, 0.1), (0.9, 0.3), (0.0, 0.02), (0.5, 40.0)])
def test_truncated_normal(mean, sd):
    """Kolmogorov-Smirnov against the exact truncated law, 0.1 % level, fixed seed."""
    values = sensors.parse_accuracy(f"N({mean},{sd})").draw(5, "accuracy", 0, 20, 500)[0].ravel()
    law = stats.truncnorm((0 - mean) / sd, (1 - mean) / sd, mean, sd)
    assert values.min() >= 0.0
    assert values.max() <= 1.0
    assert stats.kstest(values, law.cdf).pvalue > 1e-3
