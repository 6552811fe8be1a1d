"""What the command line tools have in common: how they refuse, and what their help says."""
import pytest

from tests.conftest import ROOT
from tools import coupling_effect, transport_table, validate, validate_steady, validate_transport
from tools.base.command import BadInput
from tools.bench import __main__ as bench
from tools.setup import doctor
from tools.stress import __main__ as stress
from tools.study import study


@pytest.mark.parametrize("tool, words", [(validate, ["poiseuille"]), (validate_steady, ["--only", "poiseuille"]),
    (validate_transport, ["drag"]), (bench, ["--parts", "transport"]), (stress, ["lattice"]),
                                         (transport_table, []), (coupling_effect, []),
                                             (study, ["cases/poiseuille.edp", "--quantity", "mean_v"])],
                                                 ids=lambda part: getattr(part, "__name__", ""))
def test_a_folder_that_freefem_takes_no_runs_in_is_refused_before_anything_runs(tool, words, tmp_path):
    """Each run was a failed row of its own."""
    with pytest.raises(BadInput, match="a b' holds signs other than letters"):
        tool.main([*words, "--out", str(tmp_path / "a b")])
    assert not (tmp_path / "a b").exists()


@pytest.mark.parametrize("tool", [validate, validate_steady, validate_transport], ids=lambda tool: tool.__name__)
def test_a_tool_names_itself(tool, capsys):
    """tools.validate_transport spoke of tools.validate, and its help had no options."""
    for words, status in ((["--no-such-option"], 3), (["--help"], 0)):
        with pytest.raises(SystemExit) as caught:
            tool.main(words)
        said, wrong = capsys.readouterr()
        assert caught.value.code == status and (f"(python -m {tool.__name__} --help" in wrong and wrong.count("\n") == 1
            if status else said.startswith(f"usage: python -m {tool.__name__} ") and "--out" in said)


@pytest.mark.parametrize("lost", ["CHOLMOD", None])
def test_the_doctor_sees_a_solver_that_freefem_lacks(lost, monkeypatch):
    """FreeFEM took UMFPACK for it, and the doctor said that all was well."""
    run_text, told = doctor.run_text, []
    text = (ROOT / "tools" / "setup" / "doctor.edp").read_text()
    monkeypatch.setattr(doctor, "run_text", lambda words: run_text(words.replace('include "tools/setup/doctor.edp"',
        text.replace(f'solver = "{lost}"', 'solver = "LACKING"'))))
    monkeypatch.setattr(doctor, "SOLVERS", ["UMFPACK", "CHOLMOD", "CG"])
    doctor.check_solvers(lambda good, words: told.append((good, words)))
    assert [words.split(":")[0] for good, words in told if not good] == ([f"solver {lost}"] if lost else []) and len(told) == 3
    assert not lost or "FreeFEM has none, and takes" in dict((good, words) for good, words in told)[False]
