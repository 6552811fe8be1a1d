"""Contacts: problems with exact answers, a QP package, the falling particles."""
from tools.validation import contact_targets as contacts

SOURCES = [
    (contacts.instances, "exact solutions, two independent solvers"),
    (contacts.row_of_disks, "isotonic regression"),
    (contacts.column, "weight above each contact"),
    (contacts.momentum, "conservation of momentum"),
    (contacts.quadratic_program, "QP package piqp"),
    (contacts.falling, "rest, no overlap, balances"),
]


def contact_accuracy(context):
    """The projection against exact answers; speed is held to its targets by tools.validate_contacts."""
    for part, source in SOURCES:
        for name, target, measured, reason in contacts.tried([part]):
            yield context.row(name, source, target, measured, at_most=target, reason=reason)


VALIDATIONS = [contact_accuracy]
