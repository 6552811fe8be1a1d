"""Why a case does not compile, in one sentence: the name and the line of the case, where FreeFEM names a line of lib/.

lexer.py     a script as words and signs, its macros; brackets, quotes, comments and ends of macros that are amiss
names.py     what a script includes, declares and calls
project.py   what the drivers need of a case (from the cases that use them) and what lib/ offers
message.py   what FreeFEM says, taken apart
case.py      the case, and what the sentences share
of_names.py  mistakes of names
of_kinds.py  mistakes of kinds and arguments
explain.py   the sentence
"""
