"""The boundary labels of every mesh of the project, and names of one's own; lib/mesh/labels.idp holds the same numbers."""
from tools.base.command import BadInput


LABELS = {
    "inlet": 1,
    "outlet": 2,
    "wall": 3,
    "diaphragm": 4,
    "obstacle": 5,
    "cylinder": 6,
    "lid": 7,
    "axis": 8,
    "left": 11,
    "right": 12,
    "bottom": 13,
    "top": 14,
    "front": 15,
    "back": 16,
}
NAMES = {number: name for name, number in LABELS.items()}
FIRST_OWN = 21  # label of the first name of one's own
LONGEST, FORBIDDEN = 60, ',;#"\\'  # of a name of a side, in lib/mesh/labels.idp too


def own_labels(names, taken):
    """{name: label} of names that are none of LABELS, numbered from FIRST_OWN in their order past the labels taken. Raises BadInput
    for a name that is not allowed."""
    found, number = {}, FIRST_OWN
    for name in names:
        if name in LABELS or name in found:
            continue
        if not 0 < len(name.encode()) <= LONGEST or name != name.strip() or any(sign in FORBIDDEN or not sign.isprintable()
            for sign in name):
            raise BadInput(f"'{name}' cannot be the name of a side: 1 to {LONGEST} characters, none of , ; # \" \\, no blank at its "
                f"ends")
        while number in taken:
            number += 1
        found[name] = number
        number += 1
    return found
