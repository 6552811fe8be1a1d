"""Several processes: no sum over them stands in a branch that depends on what one part of the mesh holds."""
import re

import pytest

from tests.rooms import closing, functions, texts

# What differs from process to process: numbers of nodes, triangles, vertices found in a part, and lists of them.
LOCAL = {"rigidCount", "rigidCandidates", "rigidNode", "cutN", "gapN", "gapCut", "windowN", "impactAt", "ghostAt", "frameNode",
    "frameEach", "frameBody", "frameLast", "frameTwice", "onsetNode", "guardNode", "framePlaneX", "partOwnW", "partOwnQ",
    "solidN", "solidNode", "solidOwner", "solidNearNode", "ghostN", "ghostNode", "ghostOwner", "ghostHit", "fluxN", "fluxNear",
    "fluxNode", "leavingN", "schurEdge", "schurNumber", "partGiven", "partNeeds"}
COLLECTIVE = {"ranksSum", "ranksMax", "ranksMin", "ranksSums", "ranksTops", "ranksDot", "ranksReport", "partPass", "partNodes",
    "partPair", "partBeside", "partVertices", "partDotW", "partDotQ", "partSumQ", "partSolve", "partGatherW", "partGatherQ",
    "partPoints", "rigidSums", "rigidAdd", "rigidTotal", "partTriple", "partGather", "solidSums", "solidAdd",
    "ghostLook", "poissonSolve", "ranksJoin", "pressureApply", "schurSolve", "schurSum"}
# Functions that compare the size of a list of a part with more than 0: both branches give the same values at the nodes of the part.
BOTH_WAYS = {"rigidFindHere": "rigidSeenX", "ghostForce": "rowsShare", "gapLocate": "rowsShare", "pressureCarryHere": "rowsShare",
    "windowCarry": "rowsShare", "impactFind": "impactAt.n > n"}
ROOMS = ("lib/flow/", "lib/immersed/", "lib/motion/", "lib/scheme/", "lib/record/", "lib/spheres/")


def all_functions():
    """(name, body) of each function of the rooms that several processes run; rooms may have functions of one name (krylovApply)."""
    return [(name, body) for path, text in texts().items() if path.startswith(ROOMS) for name, (_, body) in functions(text).items()]


def collective(bodies):
    """Names of the functions that reach a sum over the processes, directly or through others."""
    found, before = set(COLLECTIVE), 0
    while before != len(found):
        before = len(found)
        found |= {name for name, body in bodies if found & set(re.findall(r"\w+", body))}
    return found


def reduced(condition):
    """A condition without what is the same on all processes because it was summed."""
    while head := re.search(r"\branks(?:Max|Min|Sum)\s*\(", condition):
        condition = condition[: head.start()] + "same" + condition[closing(condition, head.end()) :]
    return condition


def branches(body):
    """(condition, what it controls, what follows) of each if, while and for of a body, and of each choice by ? and :."""
    for head in re.finditer(r"\b(if|while|for)\s*\(", body):
        end = closing(body, head.end())
        begin = re.compile(r"\s*").match(body, end).end()
        after = closing(body, begin + 1) if body[begin : begin + 1] == "{" else body.find(";", begin) + 1
        yield body[head.end() : end - 1], body[begin:after], "" if head.group(1) == "for" else body[after:]
    for statement in re.split(r"[;{}]", body):
        condition, mark, choice = statement.partition("?")
        if mark:
            yield condition, choice, ""


def wrong(name, body, sums):
    """The conditions of a function on what a part holds, or a copy of it (m = solidN), that keep this process from a sum."""
    found = []
    local = LOCAL | {copy for copy, name in re.findall(r"\b(\w+) = (\w+)\s*[,;]", body) if name in LOCAL}
    for condition, inner, rest in branches(body):
        if not local & set(re.findall(r"\w+", reduced(condition))):
            continue
        kept_from = inner + (rest if re.search(r"\breturn\b|\bcontinue\b|\bbreak\b", inner) else "")
        if (sums - {name}) & set(re.findall(r"\w+", kept_from)):
            found.append((name, condition))
    return found


def sized(body):
    """The comparisons of a body of sizes of a part, or of copies of them, with anything but 0."""
    local = LOCAL | {copy for copy, name in re.findall(r"\b(\w+) = (\w+)(?:\.n)?\s*[,;]", body) if name in LOCAL}
    word = re.compile(rf"[^;{{}}\n]*(?<![.\w])(?:{'|'.join(sorted(local))})(?:\.n)?\s*"
        r"(?:<=|>=|==|!=|<(?!=)|>(?!=))(?!\s*0\b)[^;\n]*")
    found = (match.group().strip() for match in word.finditer(reduced(body)))
    return [line for line in found if not re.search(r"\bfor \(int \w+ = \w+; \w+ < ", line)]


def test_no_process_decides_by_the_size_of_its_part():
    """Ghost values were those of all nodes on a process with few of them, and of those near the edge on another: bodies turned."""
    found = {(name, line) for name, body in all_functions() for line in sized(body)}
    assert [both for both in sorted(found) if BOTH_WAYS.get(both[0], "no such text") not in both[1]] == []
    assert sized("int every = rigidCount < ghostFew;") and sized("int m = cutN; if (m > few) f();")
    assert not sized("int every = ranksMax(rigidCount) < few; for (int k = 0; k < cutN; ++k) f(); if (rigidCount == 0) return 0;")


def test_no_sum_over_processes_in_a_branch_on_what_a_part_holds():
    bodies = all_functions()
    sums = collective(bodies)
    assert {"momentumStep", "pressureStep", "impactShare", "viscousStep", "poissonStep", "ghostAdd", "leaveFind"} <= sums
    assert [line for name, body in bodies for line in wrong(name, body, sums)] == []


@pytest.mark.parametrize("body, bad", [
    ("if (rigidCount == 0) return 0; total = ranksSum(mine);", True),
    ("if (rigidCount > 0) { ranksSums(force); }", True),
    ("while (gapN > 0) rest = partDotQ(r, z);", True),
    ("if (rigidCount > 0) force = G*values; ranksSums(force);", False),
    ("if (rigidEvery == 0) return 0; ranksSums(force);", False),
    ("int m = solidN, n = sphereN; if (m == 0) return 0; ranksSums(force);", True),
    ("int m = solidN, n = sphereN; if (n == 0) return 0; ranksSums(force);", False),
    ("for (int k = 0; k < cutN; ++k) sum += ranksSum(a[k]);", True),
    ("for (int k = 0; k < bodyNumber; ++k) sum += ranksSum(a[k]);", False),
    ("for (int k = 0; k < cutN; ++k) sum += a[k]; sum = ranksSum(sum);", False),
    ("real sum = rigidCount > 0 ? ranksSum(a.sum) : 0;", True),
    ("real sum = rigidEvery > 0 ? ranksSum(a.sum) : 0; int n = rigidCount > 0 ? 1 : 0;", False),
    ("if (ranksMax(1.*(rigidCandidates > 0)) > 0) { ranksSums(force); }", False),
])
def test_the_rule_itself(body, bad):
    assert bool(wrong("f", body, set(COLLECTIVE))) == bad
