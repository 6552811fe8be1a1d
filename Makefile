# make run and make test do everything a bare Debian 12, 13 or Ubuntu needs first.
# FREEFEM names another program, for instance: make test FREEFEM=/opt/ff/bin/FreeFem++

FREEFEM ?= FreeFem++
PYTHON := .venv/bin/python
RUN ?= results/pipe_obstacles/make_run
export FREEFEM
# The matrices are small: threads of the BLAS would only get in each other's way.
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1

.PHONY: help run test validate bench stress docs doctor meshes setup clean

help:
	@echo 'make run              50 rigid particles in a pipe with obstacles, with pictures and a film'
	@echo 'make test             the tests, 12 to 15 minutes on 2 cores (one file: make test TESTS=tests/mesh/test_mesh.py)'
	@echo 'make validate         slow comparisons with published results and a report (one: CASE=settling_disk)'
	@echo 'make stress           stability maps and their limits, half an hour of CPU (QUICK=1: 5 minutes; MAPS="gap jam"; JOBS=2)'
	@echo 'make bench            error against CPU time, this and other programs, 30 to 50 minutes (5: make bench QUICK=1)'
	@echo 'make docs             the pages of docs/ as a web site in results/docs (begin with results/docs/index.html)'
	@echo 'make doctor           versions, plug-ins, and a check of each linear solver'
	@echo 'make meshes           makes the default meshes of meshes/ anew'
	@echo 'make setup            installs what is missing (the others do this too)'
	@echo 'make clean            removes .venv and caches; runs in results/ stay'

# The run folder of an earlier make run is replaced.
run: setup
	$(PYTHON) -m tools.run cases/pipe_obstacles.edp -out $(RUN) -overwrite 1 -fields 0.02
	$(PYTHON) -m tools.plot $(RUN)
	$(PYTHON) -m tools.bodies $(RUN)
	$(PYTHON) -m tools.compress $(RUN)
	@echo 'Tables, pictures and lists of files for ParaView (.pvd) are in $(RUN):'
	@ls $(RUN)/*.csv $(RUN)/*.png $(RUN)/*.mp4 $(RUN)/*.gif $(RUN)/*.pvd 2>/dev/null || true

TESTS ?= tests
test: setup
	$(PYTHON) -m pytest -q -n 2 $(TESTS)

validate: setup
	$(PYTHON) -m tools.validate $(CASE)

stress: setup
	$(PYTHON) -m tools.stress $(if $(QUICK),--quick) $(if $(JOBS),--jobs $(JOBS)) $(MAPS)

# Writes results/bench; installs the packages to compare with into .venv.
bench: setup
	$(PYTHON) -m tools.bench $(if $(QUICK),--quick)

# Sphinx has an environment of its own, which only this target needs. A warning is an error.
.venv/docs/complete: docs/requirements.txt | setup
	$(PYTHON) -m venv --clear .venv/docs
	.venv/docs/bin/python -m pip install --quiet --disable-pip-version-check --no-input -r docs/requirements.txt
	touch $@

docs: setup .venv/docs/complete
	rm -rf results/docs
	.venv/docs/bin/python -m sphinx -q -W --keep-going -E -b html -d results/docs_cache docs results/docs
	@echo 'The pages are in results/docs/index.html'

doctor: setup
	$(PYTHON) -m tools.doctor

meshes: setup
	$(PYTHON) -m tools.default_meshes

setup:
	@tools/setup/setup.sh

clean:
	rm -rf .venv .setup.lock .pytest_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
