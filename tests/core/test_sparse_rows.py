"""Rows of a sparse matrix as lists (lib/core/sparse_rows.idp) against SciPy's sparse matrices."""
import numpy as np
import pytest
from scipy import sparse

from tests.tables import rows

ASK = """
include "lib/core/sparse_rows.idp"
int[int] I = [ROWS], J = [COLUMNS], list = [LIST], all = [ALL];
real[int] C = [VALUES];
matrix A = [I, J, C];
A.resize(HIGH, WIDE);
int[int] column(1), who(0), at(0), once(0);
real[int] entry(1), first(1), count(1), value(0), mark(NUMBERS), x = 1:WIDE;
rowsOf(A, column, entry, first, count);
cout.precision(15);
for (int i = 0; i < HIGH; ++i) cout << "row " << first[i] << " " << count[i] << endl;
int n = rowsList(list, column, entry, first, count, who, at, value);
for (int k = 0; k < n; ++k) cout << "list " << who[k] << " " << at[k] << " " << value[k] << endl;
matrix P;
rowsPart(list, column, entry, first, count, WIDE, P);
real[int] y = P*x;
cout << "size " << P.n << " " << P.m << endl;
for (int k = 0; k < y.n; ++k) cout << "product " << y[k] << endl;
rowsOnce(all, mark, once);
for (int k = 0; k < once.n; ++k) cout << "once " << once[k] << endl;
"""


@pytest.mark.parametrize("seed, high, wide", [(0, 7, 5), (1, 40, 90), (2, 1, 3)])
def test_rows_and_parts_are_those_of_scipy(seed, high, wide, freefem_text):
    rng = np.random.default_rng(seed)
    filled = np.unique(rng.integers(0, high * wide, 3 * high))
    # some rows are empty
    matrix = sparse.csr_matrix((rng.uniform(0.5, 2, len(filled)), (filled // wide, filled % wide)), (high, wide))
    chosen, numbers = rng.integers(0, high, 2 * high), rng.integers(0, 30, 50)
    coo = matrix.tocoo()
    text = ASK
    for word, value in {"ROWS": coo.row, "COLUMNS": coo.col, "VALUES": coo.data, "LIST": chosen, "ALL": numbers}.items():
        text = text.replace(f"[{word}]", "[" + ", ".join(repr(v.item()) for v in value) + "]")
    out = freefem_text(text.replace("HIGH", str(high)).replace("WIDE", str(wide)).replace("NUMBERS", "30")).stdout
    np.testing.assert_array_equal(rows(out, "row"), np.column_stack([matrix.indptr[:-1], np.diff(matrix.indptr)]))
    part = matrix[chosen]
    np.testing.assert_allclose(rows(out, "list"), np.column_stack([np.repeat(np.arange(len(chosen)), np.diff(part.indptr)),
        part.indices, part.data]), rtol=1e-13)
    np.testing.assert_array_equal(rows(out, "size")[0], [2 * high, wide])
    np.testing.assert_allclose(rows(out, "product")[:, 0], part @ np.arange(1, wide + 1), rtol=1e-13)
    once = rows(out, "once")[:, 0]
    assert len(once) == len(set(once)) and set(once) == set(numbers)
