from gpsec.report.figure_data import colours

# Colours that legend.js has.
COUNT = 6


def test_what_stands_behind_one_detector_has_one_colour_and_no_two_the_same_style():
    names = [
        "never+none",
        "lstm_glr+ukf",
        "cusum+ukf",
        "lstm_glr@1e-3/sample+ukf",
        "lstm_glr+dead_reckoning",
        "joint+ukf",
    ]
    found = colours(names, "never+none")
    assert found["never+none"] == -1
    assert {found[name] % COUNT for name in names if name.startswith("lstm_glr")} == {found["lstm_glr+ukf"] % COUNT}
    assert len({found[name] % COUNT for name in ("lstm_glr+ukf", "cusum+ukf", "joint+ukf")}) == 3
    assert len(set(found.values())) == len(names)


def test_where_there_are_more_detectors_than_colours_styles_still_differ():
    found = colours(f"d{number}" for number in range(20))
    assert len({value for name, value in found.items() if name}) == 20
