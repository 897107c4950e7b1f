# Each target makes what it needs: only Python 3.10+, make and a C++20 compiler are expected.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Hundreds of tests start Python, which keeps what it has compiled unless this is set.
export PYTHONDONTWRITEBYTECODE :=
SOURCES := $(shell find core bindings src viewer -type f ! -path '*/__pycache__/*' ! -name '*.wasm') CMakeLists.txt wasm.cmake pyproject.toml

.PHONY: demo page dev quick test style mypy mypy-windows core-tests sanitized docs bench bench-web report quality yyjson npm types clean

# The built-in scene, completed from 5 % of its pixels.
demo: $(VENV)/installed-native
	@mkdir -p out
	$(BIN)/bobrossnet render --fraction 5% --panels --out out/demo.png

# The viewer's page, which takes another minute: then `bobrossnet view` shows it.
page: $(VENV)/installed

# For editing: the package as its sources are. Python's files need nothing after an edit; after one of C++, `make dev` compiles it.
# WASM=ON also builds the page's modules.
WASM ?= OFF
dev: $(VENV)/editable
	@$(BIN)/cmake --build $(DEV)
	@$(BIN)/cmake --install $(DEV) --prefix $(wildcard $(VENV)/lib/python3*/site-packages) > /dev/null

# The tests of what differs from REV.
REV ?= HEAD
quick: dev
	$(BIN)/python tests/quick.py --since $(REV)

# Style, types and the core's own tests, two at a time because most of them use one core; then everything else.
test: $(VENV)/installed-test $(VENV)/chromium clang
	$(MAKE) --jobs 2 sanitized mypy mypy-windows types style core-tests
	$(BIN)/pytest -n 2 --dist loadfile --no-loadscope-reorder

style:
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

mypy:
	$(BIN)/mypy

mypy-windows:
	$(BIN)/mypy --platform win32 --cache-dir .mypy_cache/win32 src

core-tests:
	$(NATIVE)/core_tests

sanitized:
	$(call core_tests,sanitize,-DBOBROSSNET_SANITIZE=address$(comma)undefined $(addprefix -DCMAKE_CXX_COMPILER=,$(CLANG)))

bench: $(VENV)/installed-test
	$(BIN)/python bench/trace.py
	$(BIN)/python bench/price.py
	$(BIN)/python bench/implicit.py
	$(BIN)/python bench/libfive.py
	$(BIN)/python bench/nurbs.py
	$(BIN)/python bench/complete.py
	$(BIN)/python bench/progressive.py
	$(BIN)/python bench/motion.py
	$(BIN)/python bench/color.py
	$(BIN)/python bench/everyday.py
	$(BIN)/python bench/views.py
	$(BIN)/python bench/tracers.py
	$(BIN)/python bench/async_tracers.py
	$(BIN)/python bench/learn.py

# The viewer's page in Chromium: frames a second, first pictures, memory, and its pictures beside those of half the resolution.
bench-web: $(VENV)/installed-test $(VENV)/chromium
	$(BIN)/python bench/web/viewer.py

# The report of 2019, from data set to figures: docs/report.md. Hours; SCALE=small does the same in 10 minutes.
SCALE ?= full
report: $(VENV)/installed-train
	$(BIN)/python docs/report.py --scale $(SCALE)

# How good and how steady pictures are, by network and pixel order: docs/quality.md. An hour, minutes for other weights.
quality: $(VENV)/installed-train
	$(BIN)/python docs/quality.py --scale $(SCALE)

# The documents as a site, with the reference and the page: out/site/index.html.
docs: $(VENV)/installed-test
	$(BIN)/python -m sphinx -q -W --keep-going -c docs/site . out/site

# The reader of JSON in the core, from its tag on GitHub: without its writers, what it does not read here, and comments. Needs unifdef.
YYJSON := 0.12.0
yyjson:
	rm -rf build/yyjson && git clone --quiet --depth 1 --branch $(YYJSON) https://github.com/ibireme/yyjson build/yyjson
	cd build/yyjson/src && for file in yyjson.c yyjson.h; do \
	  unifdef -UYYJSON_DISABLE_READER $(foreach part,WRITER INCR_READER UTILS NON_STANDARD FAST_FP_CONV,-DYYJSON_DISABLE_$(part)=1) $$file > short.$$file; \
	  gcc -w -fpreprocessed -dD -E -P short.$$file > $(abspath vendor/yyjson)/$$file; done
	sed -i 's/if (char_is_space(cur\[1\]) \&\& char_is_space(cur\[2\])) {/if (true) {/' vendor/yyjson/yyjson.c  # one way to read texts of both kinds, for the page's sake
	cp build/yyjson/LICENSE vendor/yyjson

# Types of the viewer's page, as its comments say them; npm brings what checks them.
TSC := build/types/node_modules/.bin/tsc
$(TSC):
	@command -v npm > /dev/null && npm install --silent --no-save --prefix build/types typescript@7.0.2 || \
	  { echo "no npm: the types of the viewer's page are not checked"; [ -z "$$CI" ]; }

types: $(TSC)
	@[ ! -x $(TSC) ] || $(TSC) -p jsconfig.json

# The element <bob-view> as an npm package: out/npm/bob-view-VERSION.tgz.
npm: $(VENV)/installed $(TSC)
	rm -rf out/npm && $(BIN)/python -m bobrossnet.page.package out/npm $(TSC)
	cd out/npm && npm pack --silent

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

PIP := $(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check --constraint constraints.txt

# The tools stay in the environment: pip's own environment for a build has another path each time, for which all would be
# compiled again. These are the build's requirements in pyproject.toml, with CMake and ninja, and those of WebAssembly.
requirements = sed -n '/^$(1)requires = \[/,/^\]/s/^  "\(.*\)",$$/\1/p' pyproject.toml > $@.txt
$(VENV)/tools: $(BIN)/python pyproject.toml
	@$(call requirements,)
	$(PIP) --requirement $@.txt cmake ninja
	@touch $@

$(VENV)/tools-wasm: $(VENV)/tools
	@$(call requirements,build.)
	$(PIP) --requirement $@.txt
	@touch $@

# Installs by pip's arguments $(2), with CMake's definitions $(1), from the objects in $(3). One folder has those of all that is
# installed; for editing, another one has an object for each file.
NATIVE := build/native
DEV := build/dev
define install
SKBUILD_BUILD_DIR=$(or $(3),$(NATIVE)) SKBUILD_CMAKE_DEFINE="BOBROSSNET_WERROR=ON;$(1)" $(PIP) --no-build-isolation $(2)
endef

# The stamps of what is installed: an editable package takes the place of the others, and they take its place.
$(VENV)/installed-native: $(VENV)/tools $(SOURCES)
	$(call install,BOBROSSNET_TESTS=OFF;BOBROSSNET_WASM=OFF,.)
	@touch $@ && rm -f $(VENV)/editable

$(VENV)/installed: $(VENV)/tools-wasm $(SOURCES)
	$(call install,BOBROSSNET_TESTS=OFF;BOBROSSNET_WASM=ON,.)
	@touch $@ $(VENV)/installed-native && rm -f $(VENV)/editable

$(VENV)/installed-train: $(VENV)/tools-wasm $(SOURCES) constraints.txt
	$(call install,BOBROSSNET_TESTS=OFF;BOBROSSNET_WASM=ON,'.[train]')
	@touch $@ $(VENV)/installed $(VENV)/installed-native && rm -f $(VENV)/editable

$(VENV)/installed-test: $(VENV)/tools-wasm $(SOURCES) constraints.txt
	$(call install,BOBROSSNET_TESTS=ON;BOBROSSNET_WASM=ON,'.[test]')
	@touch $@ $(VENV)/installed $(VENV)/installed-native $(VENV)/installed-train && rm -f $(VENV)/editable

$(VENV)/editable: $(VENV)/tools$(if $(filter ON,$(WASM)),-wasm) CMakeLists.txt wasm.cmake pyproject.toml constraints.txt
	$(call install,BOBROSSNET_TESTS=ON;BOBROSSNET_UNITY=OFF;BOBROSSNET_WASM=$(WASM),--editable '.[test]',$(DEV))
	@touch $@ && rm -f $(VENV)/installed*

# A browser for the tests of the viewer's page: Debian's where it may be installed, else playwright's own. Without any, these
# tests are skipped, or fail where CI is set.
$(VENV)/chromium: | $(VENV)/installed-test
	@{ command -v chromium || command -v chromium-browser || command -v google-chrome || \
	   { [ "$$(id -u)" = 0 ] && apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium; } || \
	   $(BIN)/playwright install chromium; } > /dev/null && touch $@ || echo "no Chromium: tests of the viewer's page can't run"

clean:
	rm -rf $(VENV) build out

include checks.mk release/wheels.mk
