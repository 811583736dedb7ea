"""The page in a headless browser; skipped where there is none."""

import csv
import io
import shutil

import pytest

from gpsec.report.make import write_report
from gpsec.running.results import load

from .conftest import EVIL
from .worlds import write_worlds_run

playwright = pytest.importorskip("playwright.sync_api")

PROGRAMS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
TABS = ("overview", "deciding", "detection", "safety", "where", "traces", "about")


@pytest.fixture(scope="module")
def browser():
    program = next(filter(None, map(shutil.which, PROGRAMS)), None)
    with playwright.sync_playwright() as tools:
        try:
            found = tools.chromium.launch(executable_path=program, args=["--no-sandbox"])
        except playwright.Error:
            pytest.skip("there is no Chromium here")
        yield found
        found.close()


@pytest.fixture(scope="module")
def report(run_folder, tmp_path_factory):
    return write_report(load(run_folder), path=tmp_path_factory.mktemp("page") / "report.html")


@pytest.fixture(params=["light", "dark", "phone"])
def page(request, browser, report):
    size = {"width": 390, "height": 844} if request.param == "phone" else {"width": 1280, "height": 900}
    scheme = "dark" if request.param == "dark" else "light"
    context = browser.new_context(viewport=size, color_scheme=scheme, offline=True, accept_downloads=True)
    page = context.new_page()
    said = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(report.as_uri())
    page.wait_for_selector("html[data-ready]")
    yield page
    assert said == []
    assert page.title() == "gpsec: lane"
    context.close()


def drawn(page, key):
    """Names of what a figure shows, or the sentence that it shows instead."""
    script = """(key) => { const figure = document.getElementById(key); const canvas = figure.querySelector('.canvas');
        return canvas.hidden ? figure.querySelector('.why').textContent : canvas.data.map((trace) => trace.name); }"""
    return page.evaluate(script, key)


def test_every_tab_shows_its_figures(page):
    for tab in TABS:
        page.click(f"#tab-{tab}")
        assert page.locator(".panel:visible").count() == 1
        for figure in page.locator(".panel:visible figure.plot").all():
            key = figure.get_attribute("id")
            assert len(drawn(page, key)) > 0
            assert figure.locator(".canvas svg.main-svg").count() > 0 or figure.locator(".why").is_visible()
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_the_choice_of_an_attack_changes_figures_and_tables(page):
    page.click("#tab-detection")
    assert "cusum" in drawn(page, "roc")
    page.select_option("#attack", "jamming")
    assert drawn(page, "roc").startswith("No sample under this attack could be scored")
    rows = page.locator("#detection tr[data-attack]:visible")
    assert {row.get_attribute("data-attack") for row in rows.all()} == {"jamming"}
    page.check("#detection .every")
    assert {row.get_attribute("data-attack") for row in rows.all()} == {"bias", "jamming", EVIL}
    page.select_option("#attack", EVIL)
    page.wait_for_selector("#roc .canvas:visible")
    assert page.locator("#roc img").count() == 0


def test_what_a_figure_offers_of_its_own(page):
    page.click("#tab-where")
    assert "left its lane with never+none" in drawn(page, "map")
    options = page.locator("#map select[data-pick=detector] option")
    assert options.all_text_contents() == ["cusum"]
    page.click("#tab-traces")
    labels = page.locator("#trace_path select option").all_text_contents()
    page.select_option("#trace_path select", labels[-1])
    assert page.input_value("#trace_residual select") == labels[-1]


def test_data_of_a_figure_can_be_downloaded(page):
    page.click("#tab-safety")
    with page.expect_download() as caught:
        page.click("#cross_track_error .csv")
    assert caught.value.suggested_filename == "cross_track_error.csv"
    with open(caught.value.path(), encoding="utf-8", newline="") as file:  # noqa: PTH123
        rows = list(csv.DictReader(io.StringIO(file.read())))
    mine = [row for row in rows if (row["series"], row["attack"]) == ("never+none", "bias")]
    assert [float(row["time since the attack began (s)"]) for row in mine] == [0.0, 1.0, 2.0, 3.0]
    assert {row["attack"] for row in rows} == {"bias", "jamming", EVIL}


def test_lines_are_told_apart_and_hidden_by_their_name(page):
    page.click("#tab-safety")
    styles = "(key) => document.getElementById(key).querySelector('.canvas').data.map((one) => [one.name, one.visible])"
    shown = dict(page.evaluate(styles, "cross_track_error"))
    assert shown["cusum+ukf"] is not False
    names = page.locator("#cross_track_error .legend button").all_text_contents()
    assert sorted(name.strip("●■◆▲▼★✚✶") for name in names) == ["cusum+ukf", "never+none"]
    page.locator("#cross_track_error .legend button", has_text="cusum+ukf").click()
    shown = dict(page.evaluate(styles, "cross_track_error"))
    assert shown["cusum+ukf"] is False
    assert shown["cusum+ukf, 90 %"] is False
    assert shown["never+none"] is not False


def test_the_rate_of_false_positives_is_drawn_by_its_logarithm(page):
    page.click("#tab-detection")
    kind = "document.querySelector('#roc .canvas')._fullLayout.xaxis.type"
    assert page.evaluate(kind) == "log"
    assert len(drawn(page, "auc")) == 1
    assert page.locator("#auc .xtick").count() >= 2  # areas of one decade have numbers on their axis, too


def test_light_and_dark(page):
    before = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.click("#theme")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != before


def test_everything_is_printed(page):
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.locator(".panel:visible").count() == len(TABS)
    groups = page.locator("[data-group]").count()
    assert page.locator("[data-group]:visible").count() == groups > 0
    page.wait_for_function("document.querySelectorAll('.canvas:not([hidden]) svg.main-svg').length > 10")
    wide = "[...document.querySelectorAll('.canvas')].every((one) => one.scrollWidth <= document.body.clientWidth)"
    assert page.evaluate(wide)
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.emulate_media(media="screen")
    assert page.locator(".panel:visible").count() == 1


@pytest.mark.parametrize("width", [1280, 390])
def test_the_page_of_a_run_in_closed_loop(browser, tmp_path, width):
    page_file = write_report(load(write_worlds_run(tmp_path / "run")))
    context = browser.new_context(viewport={"width": width, "height": 900}, offline=True)
    page, said = context.new_page(), []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(page_file.as_uri())
    page.wait_for_selector("html[data-ready]")
    expected = {"overview": ["effects"], "where": ["map"], "road": ["road"]}
    expected["crash"] = ["crash_path", "crash_beside", "crash_speed"]
    for tab, keys in expected.items():
        page.click(f"#tab-{tab}")
        for key in keys:
            assert len(drawn(page, key)) > 0, key
            assert page.locator(f"#{key} .canvas svg.main-svg").count() > 0, key
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), tab
    assert page.locator("img").count() == 0
    assert said == []
    context.close()
