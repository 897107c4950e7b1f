# Each target makes what it needs: only Python 3.10+, make and a C++20 compiler are expected.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SOURCES := $(shell find core bindings src -type f ! -path '*/__pycache__/*') CMakeLists.txt wasm.cmake pyproject.toml

.PHONY: demo test check-all check-threads check-memory check-clang check-arm check-interruptions clang bench bench-web report quality vendor types clean

# The built-in scene, completed from 5 % of its pixels.
demo: $(VENV)/installed
	@mkdir -p out
	$(BIN)/bobrossnet render --fraction 5% --panels --out out/demo.png

# Style, types, the core's own tests (as they ship, and by Clang under the sanitizers), then everything else.
test: $(VENV)/installed-test $(VENV)/chromium clang
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	build/*-abi3-*/core_tests
	$(call core_tests,sanitize,-DBOBROSSNET_SANITIZE=address$(comma)undefined $(addprefix -DCMAKE_CXX_COMPILER=,$(CLANG)))
	$(BIN)/pytest -n 2 --dist loadfile --no-loadscope-reorder

# Builds the core's tests in build/NAME with CMake's further arguments, and runs them.
comma := ,
define core_tests
$(BIN)/cmake -S . -B build/$(1) -G Ninja -DCMAKE_MAKE_PROGRAM=$(abspath $(BIN)/ninja) -DBOBROSSNET_TESTS=ON $(2)
$(BIN)/cmake --build build/$(1) && $(3) build/$(1)/core_tests
endef

# What takes too long for `make test`: threads under ThreadSanitizer, the Python module under the other sanitizers, Clang's
# code as it would ship, 64-bit ARM, work that is killed at random moments, full disks, files of other users.
check-all: check-threads check-memory check-clang check-arm check-interruptions

bench: $(VENV)/installed-test
	$(BIN)/python bench/trace.py
	$(BIN)/python bench/implicit.py
	$(BIN)/python bench/nurbs.py
	$(BIN)/python bench/complete.py
	$(BIN)/python bench/progressive.py
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

# The loaders of three.js that the viewer's page ships, from npm. `from 'three'` becomes a path, which workers need, and types
# are not checked; the rest is as it came.
THREE := 0.187.0
VENDOR := src/bobrossnet/viewer/vendor/three
vendor:
	rm -rf build/three $(VENDOR) && mkdir -p build/three $(VENDOR)/loaders $(VENDOR)/utils
	cd build/three && npm pack --silent three@$(THREE) && tar xzf three-$(THREE).tgz
	cp build/three/package/build/three.core.js $(VENDOR) && cp build/three/package/LICENSE $(VENDOR)/LICENSE.txt
	cd build/three/package/examples/jsm && cp loaders/STLLoader.js loaders/GLTFLoader.js $(abspath $(VENDOR))/loaders
	cd build/three/package/examples/jsm && cp utils/BufferGeometryUtils.js utils/SkeletonUtils.js $(abspath $(VENDOR))/utils
	sed -i "s|from 'three';|from '../../../files/three.js';|" $(VENDOR)/loaders/*.js $(VENDOR)/utils/*.js
	sed -i '1i // @ts-nocheck' $(VENDOR)/*.js $(VENDOR)/loaders/*.js $(VENDOR)/utils/*.js

# Types of the viewer's page, as its comments say them; npm brings what checks them.
types:
	npm install --silent --no-save --prefix build/types typescript@7.0.2
	build/types/node_modules/.bin/tsc -p jsconfig.json

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/installed: $(BIN)/python $(SOURCES)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check .
	@touch $@

$(VENV)/installed-train: $(BIN)/python $(SOURCES) constraints.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt '.[train]'
	@touch $@ $(VENV)/installed

$(VENV)/installed-test: $(BIN)/python $(SOURCES) constraints.txt
	SKBUILD_CMAKE_DEFINE=BOBROSSNET_TESTS=ON \
	  $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt '.[test]'
	@touch $@ $(VENV)/installed $(VENV)/installed-train

# A browser for the tests of the viewer's page: Debian's where it may be installed, else playwright's own. Without any, these
# tests are skipped, or fail where CI is set.
$(VENV)/chromium: | $(VENV)/installed-test
	@{ command -v chromium || command -v chromium-browser || command -v google-chrome || \
	   { [ "$$(id -u)" = 0 ] && apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium; } || \
	   $(BIN)/playwright install chromium; } > /dev/null && touch $@ || echo "no Chromium: tests of the viewer's page can't run"

# The newest Clang here; without any, Debian's where it may be installed, else the sanitizers are of the package's compiler.
CLANG = $(shell ls /usr/bin/clang++ /usr/bin/clang++-[0-9]* 2> /dev/null | sort -V | tail -1)
clang:
	@[ -n "$(CLANG)" ] || \
	  { [ "$$(id -u)" = 0 ] && apt-get update -qq && apt-get install -y -qq --no-install-recommends clang-19 libclang-rt-19-dev; } > /dev/null || \
	  { echo "no Clang: the core's tests are run by one compiler only"; [ -z "$$CI" ]; }

# The Python module in build/NAME/site, built with sanitizers; their libraries come before Python's own.
define sanitized_module
SKBUILD_BUILD_DIR=build/$(1) SKBUILD_CMAKE_DEFINE=BOBROSSNET_SANITIZE=$(2) \
  $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --upgrade --target build/$(1)/site .
endef
sanitized = LD_PRELOAD="$(foreach l,$(1),$(shell $(CXX) -print-file-name=lib$(l).so))" PYTHONPATH=build/$(2)/site setarch -R $(BIN)/pytest
ON_THREADS := tests/test_complete.py tests/test_custom.py tests/test_implicit.py tests/test_kernels.py tests/test_nurbs_tracing.py \
  tests/test_progressive.py tests/test_scene.py tests/test_trace.py
IN_THE_CORE := $(ON_THREADS) tests/test_channels.py tests/test_container.py tests/test_files.py tests/test_formula.py tests/test_gbuffer.py \
  tests/test_nurbs.py tests/test_nurbs_basis.py tests/test_order.py tests/test_script.py tests/test_sdf.py

check-threads: $(VENV)/installed-test
	$(call core_tests,threads,-DBOBROSSNET_SANITIZE=thread,setarch -R)
	$(call sanitized_module,threads-module,thread)
	TSAN_OPTIONS=halt_on_error=1 $(call sanitized,tsan,threads-module) $(ON_THREADS)

check-memory: $(VENV)/installed-test
	$(call sanitized_module,memory-module,address$(comma)undefined)
	ASAN_OPTIONS=detect_leaks=0 $(call sanitized,asan ubsan,memory-module) $(IN_THE_CORE)

check-clang: $(VENV)/installed-test clang
	$(call core_tests,clang,-DCMAKE_CXX_COMPILER=$(CLANG))

# Debian: g++-aarch64-linux-gnu and qemu-user.
check-arm: $(VENV)/installed-test
	$(call core_tests,arm,-DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++,\
	  qemu-aarch64 -L /usr/aarch64-linux-gnu)

check-interruptions: $(VENV)/installed-test
	$(BIN)/pytest tests/checks

clean:
	rm -rf $(VENV) build out
