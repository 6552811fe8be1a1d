"""The boundary labels of every mesh of the project; lib/mesh/labels.idp holds the same numbers."""

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
