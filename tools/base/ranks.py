"""Several processes: the launcher of FreeFEM's own MPI."""
import shutil
from pathlib import Path

from tools.base.command import BadInput
from tools.base.runner import freefem

# One thread each for the BLAS. Open MPI refuses the administrator and more processes than cores unless it is told so; containers
# have no other user. Where a process ends with a status, Open MPI adds ten lines to the one that says why, unless it is quiet.
MPI_ENVIRONMENT = {"OPENBLAS_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_orte_execute_quiet": "1"}


def launcher():
    """The path of ff-mpirun beside FreeFem++, or of the first on the search path. Raises BadInput where there is none."""
    beside = Path(freefem()).with_name("ff-mpirun")
    found = str(beside) if beside.is_file() else shutil.which("ff-mpirun")
    if not found:
        raise BadInput("several processes need ff-mpirun, which comes with FreeFEM where that was built with MPI; python -m "
            "tools.doctor says more")
    return found
