"""The rule on commit messages is held, and every linter that a change has to pass runs before a commit, too."""

import importlib.util
import re
import subprocess

import pytest
import yaml


@pytest.fixture(scope="module")
def commits(repository):
    spec = importlib.util.spec_from_file_location("commits", repository / ".ci" / "commits.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("message", "says"),
    [
        ("Add a thing\n\nSince it was missed.", ""),
        (f"Fix {'x' * 68}\n\nWhy.", ""),
        (f"Fix {'x' * 69}\n\nWhy.", "73 characters"),
        ("Adds a thing\n\nWhy.", "begins with none of Add, Fix"),
        ("A thing\n\nWhy.", "begins with none of"),
        ("Add a thing", "no body"),
        ("Add a thing\n\n \n", "no body"),
        ("Add a thing\nand more", "empty line"),
        ("Merge branch 'x'", ""),
        ('Revert "Add a thing"', ""),
    ],
)
def test_a_message_is_held_to_the_rule(commits, message, says):
    found = commits.breaches_of(message)
    assert (says in found[0]) if says else found == []


def test_commits_since_the_rule_are_looked_at_and_comments_of_a_message_are_not(commits, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    git = ["git", "-c", "user.name=n", "-c", "user.email=e", "-c", "commit.gpgsign=false"]
    assert commits.main([]) == 0  # no history
    subprocess.run([*git, "init", "-q"], check=True)
    for message in ("Old style", "Add it\n\nWhy.", "wrong"):
        subprocess.run([*git, "commit", "-q", "--allow-empty", "-m", message], check=True)
        if message == "Old style":
            told = subprocess.run([*git, "rev-parse", "HEAD"], check=True, capture_output=True, text=True).stdout
            monkeypatch.setattr(commits, "SINCE", told.strip())
    assert commits.main([]) == 1
    assert len(capsys.readouterr().err.splitlines()) == 2  # of the last one: its first word, and no body
    (tmp_path / "message").write_text("# a comment of git\nAdd it\n\nWhy.\n# another\n")
    assert commits.main(["--message", "message"]) == 0


def test_hooks_run_every_linter(repository):
    makefile = (repository / "Makefile").read_text()
    recipe = makefile.split("\nlint:")[1].split("\n\n")[0]
    wanted = re.findall(r"\$\(BIN\)/([^\n]+)", recipe)
    hooks = yaml.safe_load((repository / ".pre-commit-config.yaml").read_text())["repos"][0]["hooks"]
    entries = [hook["entry"].removeprefix(".venv/bin/").removesuffix(" --message") for hook in hooks]
    assert entries == [line.removesuffix(" .") for line in wanted]
