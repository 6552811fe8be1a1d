"""Nothing that a user or a file supplies is read as a command: a lint of all calls of the shell, and crafted words, names, files
and folders."""
import hashlib
import os
import re
import shutil
import subprocess
from functools import lru_cache

import pytest

from tests.conftest import FREEFEM, ROOT, eventually, run_freefem, run_limited as run
from tests.lint import files
from tests.tables import assert_refused

LITERAL = r'"(?:\\.|[^"\\\n])*"'
CALLED = re.compile(r"\b(exec|shellRun[1-4]?)\s*\(")
SHELL = "lib/core/shell.idp"


def without_comments(text):
    """The script without comments; strings stay."""
    return re.sub(rf"({LITERAL})|//[^\n]*", lambda match: match.group(1) or "", text)


def arguments(text, start):
    """The arguments of the call whose opening bracket stands before `start`."""
    found, depth, at, begin = [], 0, start, start
    while depth >= 0:
        string = re.compile(LITERAL).match(text, at)
        if string:
            at = string.end()
            continue
        depth += (text[at] in "([{") - (text[at] in ")]}")
        if depth == 0 and text[at] == "," or depth < 0:
            found.append(text[begin:at].strip())
            begin = at + 1
        at += 1
    return found


@lru_cache(maxsize=None)
def constants():
    """Names of strings that are declared once, as a sum of literals, and never assigned again."""
    known = set()
    for path in files(".idp"):
        text = without_comments((ROOT / path).read_text())
        for name in re.findall(rf"\bstring (\w+) = {LITERAL}(?:\s*\+\s*{LITERAL})*;", text):
            if len(re.findall(rf"\b{name}\s*=[^=]", text)) == 1:
                known.add(name)
    return known


def loose_calls(text, known):
    """The commands of a script that are not constant: (name of the call, what is put into it)."""
    text, loose = without_comments(text), []
    for call in CALLED.finditer(text):
        if text[:call.start()].endswith("func int "):
            continue
        command = re.sub(LITERAL, '""', arguments(text, call.end())[-1])
        rest = [part.strip() for part in command.split("+")]
        loose += [(call.group(1), part) for part in rest if part != '""' and part not in known]
    return loose


@pytest.mark.parametrize("path", [path for path in files(".idp") + files(".edp")
    if path.startswith(("lib/", "scripts/", "cases/"))])
def test_every_command_is_constant(path):
    text = (ROOT / path).read_text()
    assert not re.search(r'\bload\s+"pipe"|\bpstream\b', text), "no pipes"
    loose = loose_calls(text, constants())
    # the number of the scratch folder, the watcher's constant text, and what shellRun hands on: words from a file, or in quotes
    if path == SHELL:
        assert {part for _, part in loose} == {"shellNumber", "put", "program"}
    else:
        assert loose == [] and "exec(" not in without_comments(text)


def test_the_lint_finds_what_it_looks_for():
    text = """string known = "a" + "b"; // exec("x" + hidden)
    exec("rm " + file); shellRun1(file, "cat \\"$1\\"" + more); shellRun2(a(1, "q)"), b, known + "c"); shellRun("(" + "ok");"""
    assert loose_calls(text, {"known"}) == [("exec", "file"), ("shellRun1", "more")]


# What a shell would run, in every way of quoting.
POISON = ["x\nEND_OF_LINE\ntouch {0}\n:", "'; touch {0}; '", '"; touch {0}; "', "$(touch {0})", "`touch {0}`", "\\'; touch {0} #",
    "|touch {0}", "\r\ntouch {0}\r\n"]
DRIVERS = {
    "resolved": ["cases/template.edp"], "flow": ["cases/poiseuille.edp"], "steady laminar": ["cases/cavity.edp"],
        "steady": ["cases/pipe_flow.edp"],
    "contacts": ["cases/falling_particles.edp"], "transport": ["tests/transport/scripts/analytic.edp"],
        "projection": ["scripts/project_velocities.edp"],
}


def assert_nothing_runs(script, words, tmp_path):
    """The script refuses these words, each list in a run of its own, and no command in them is run."""
    for given in words:
        assert_refused(run(*script, *given, *([] if "-out" in given else ["-out", tmp_path / "run"])), (3,))
    assert not (tmp_path / "pwned").exists() and not (tmp_path / "run").exists()


@pytest.mark.parametrize("poison", POISON)
def test_no_option_is_read_as_a_command(poison, reading, tmp_path):
    word = poison.format(tmp_path / "pwned")
    assert_nothing_runs([reading], (["-dt", word], ["-mesh", word], ["-out", word], ["-" + word, "1"], [word]), tmp_path)


@pytest.mark.parametrize("driver", ["resolved", "contacts", "projection"])
def test_no_driver_reads_an_option_as_a_command(driver, tmp_path):
    """All ways of quoting in one value, and one of them in place of an option: the search for an option like it is slow for long
    ones."""
    word, short = "".join(POISON).format(tmp_path / "pwned"), POISON[3].format(tmp_path / "pwned")
    assert_nothing_runs(DRIVERS[driver], (["-dt", word], ["-mesh" if driver == "resolved" else "-out", word], ["-" + short, "1"],
        [short]), tmp_path)


@pytest.mark.parametrize("driver", DRIVERS)
def test_a_line_end_in_an_option_is_refused_in_one_line(driver, tmp_path):
    word = POISON[0].format(tmp_path / "pwned")
    for words in (["-dt", word], ["-nothing", word]):
        assert_refused(run(*DRIVERS[driver], *words), (3,))
    assert not (tmp_path / "pwned").exists()


@pytest.mark.parametrize("name", ["it's $(touch pwned).edp", 'a "quote".edp', "`touch pwned`; x.edp"])
def test_a_script_may_have_any_path(name, tmp_path):
    script = tmp_path / name
    script.write_text((ROOT / "cases/falling_particles.edp").read_text())
    words = [script, "-number", 3, "-tend", 0.1, "-checkpoint", 2]
    run_freefem(*words, "-out", tmp_path / "run")
    run_freefem(*words[:3], "-tend", 0.2, "-checkpoint", 2, "-restart", tmp_path / "run")
    assert not (ROOT / "pwned").exists() and not (tmp_path / "pwned").exists()


def test_a_scratch_folder_may_have_any_path(tmp_path, monkeypatch):
    folder = tmp_path / "it's $(touch pwned) \"mine\""
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    (tmp_path / "one.csv").write_text("id,x,y,radius,density\n7,0.7,2,0.2,2\n")
    run_freefem("cases/template.edp", "-tend", 0.0025, "-particles", tmp_path / "one.csv", "-out", tmp_path / "run")
    assert len(set(row.split(",")[2] for row in (tmp_path / "run/particles.csv").read_text().splitlines()[1:])) == 4
    assert not (ROOT / "pwned").exists() and eventually(lambda: list(folder.iterdir()) == [])


def sealed(folder, base):
    """Renews the checksums of a checkpoint whose files have been changed."""
    sums = folder / f"{base}.sha"
    lines = [line for line in sums.read_text().splitlines() if line.startswith("#")]
    names = [line.split()[1] for line in sums.read_text().splitlines() if not line.startswith("#")]
    sums.write_text("".join(f"{hashlib.sha256((folder / name).read_bytes()).hexdigest()}  {name}\n" for name in names)
        + "\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A run with checkpoints: (its words, its folder)."""
    folder = tmp_path_factory.mktemp("kept") / "run"
    words = ["cases/falling_particles.edp", "-number", 3, "-checkpoint", 2, "-every", 0]
    run_freefem(*words, "-tend", 0.1, "-out", folder)
    return words, folder


@pytest.mark.parametrize("line, change", [
    (1, lambda row, mark: row + f"'; touch {mark}; '"), (1, lambda row, mark: row.replace(";", f";x=$(touch {mark});", 1)),
        (0, lambda row, mark: f"'; touch {mark}; '"),
    (2, lambda row, mark: row.replace(" ", f"\t-f\t{mark}.awk ", 1)), (2, lambda row, mark: row.replace(" ", f" $(touch\t{mark})",
        1)),
    (2, lambda row, mark: row.split()[0] + f" 0.04;touch\t{mark} " + " ".join(row.split()[2:]))])
def test_a_crafted_checkpoint_runs_nothing(kept, line, change, tmp_path):
    """Its checksums are right: they keep off damage, not intent."""
    words, folder, mark = kept[0], tmp_path / "run", tmp_path / "pwned"
    shutil.copytree(kept[1], folder)
    (tmp_path / "pwned.awk").write_text(f'BEGIN {{ system("touch {mark}") }}')
    base = max(folder.glob("restart_*.sha")).stem
    text = (folder / f"{base}.txt").read_text().splitlines()
    text[line] = change(text[line], mark)
    (folder / f"{base}.txt").write_text("\n".join(text) + "\n")
    sealed(folder, base)
    done = run(*words, "-tend", 0.2, "-restart", folder)
    assert not mark.exists()
    if done.returncode:
        assert_refused(done, (3, 4, 5))


@pytest.mark.parametrize("names", ["../../../etc/hostname", "/dev/zero", "-c", "restart_000000001.txt ; touch pwned",
    "$(touch pwned)"])
def test_a_crafted_list_of_checksums_is_not_followed(kept, names, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(kept[1], folder)
    for sums in folder.glob("restart_*.sha"):
        sums.write_text(f"{'0' * 64}  {names}\n# form1 x\n")
    (folder / "restart_$(touch pwned).sha").write_text("x")
    assert_refused(run(*kept[0], "-tend", 0.2, "-restart", folder, timeout=30), (3,), "no complete checkpoint")
    assert not list(tmp_path.rglob("pwned")) and not (ROOT / "pwned").exists()


def test_a_crafted_list_of_files_leads_nowhere(kept, tmp_path):
    """-overwrite 1 removes plain files of the folder alone, whatever the list says."""
    folder, mine = tmp_path / "run", tmp_path / "mine.csv"
    shutil.copytree(kept[1], folder)
    mine.write_text("t,a\n99,1\n")
    (folder / "link.csv").symlink_to(mine)
    (folder / ".files").open("a").write(f"../mine.csv\n{mine}\n-rf\n*\nlink.csv\n$(touch {tmp_path}/pwned)\n`touch "
        f"{tmp_path}/pwned`\n")
    (folder / "own.txt").write_text("mine")
    run_freefem(*kept[0], "-tend", 0.04, "-out", folder, "-overwrite", 1)
    assert mine.read_text() == "t,a\n99,1\n" and (folder / "own.txt").exists() and (folder
        / "link.csv").is_symlink() and not (tmp_path / "pwned").exists()


@pytest.mark.parametrize("name", ["walls", "disks", "bodies", "message", "words"])
def test_a_foreign_scratch_folder_is_never_entered(name, tmp_path, monkeypatch):
    """Another user may have made one of the same name: the number of a process can be guessed."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    start = f"""for k in $(seq 0 40); do p=$(($$ + k)); mkdir -p "{tmp_path}/freefem-particles-$p.1"; echo '1 9 9 9 9' > "{tmp_path}/freefem-particles-$p.1/{name}"; done
    exec {FREEFEM} -nw scripts/project_velocities.edp -bodies tests/data/contact/random_50_bodies.csv -walls tests/data/contact/random_50_walls.csv -out {tmp_path}/a.csv"""
    done = subprocess.run(["sh", "-c", start], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    foreign = list(tmp_path.glob(f"freefem-particles-*.1/{name}"))
    assert len(foreign) == 41 and all(path.read_text() == "1 9 9 9 9\n" for path in foreign)
    run_freefem("scripts/project_velocities.edp", "-bodies", "tests/data/contact/random_50_bodies.csv", "-walls",
        "tests/data/contact/random_50_walls.csv", "-out", tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


@pytest.mark.parametrize("make", ["missing", "a file", "read-only"])
def test_a_scratch_folder_that_cannot_be_made_is_told(make, tmp_path, monkeypatch):
    place = tmp_path / "scratch"
    if make == "a file":
        place.write_text("mine")
    if make == "read-only":
        place.mkdir(mode=0o500)
        if os.access(place, os.W_OK):
            place = tmp_path / "proc"
            place.symlink_to("/proc/self")
    monkeypatch.setenv("TMPDIR", str(place))
    assert_refused(run("cases/template.edp", "-tend", 0.0025, "-out", tmp_path / "run"), (4,), "cannot make a scratch folder in ")
    assert not (tmp_path / "run").exists()


def test_words_of_any_length_are_refused(tmp_path):
    """An option name of 100,000 characters took 40 s."""
    for words in (["-" + "a" * 100_000, "1"], ["-dt", "1" * 100_000]):
        assert_refused(run("cases/template.edp", *words, "-out", tmp_path / "run", timeout=20), (3,), "100001 characters"
            if words[0] != "-dt" else "100000 characters")
