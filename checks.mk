# Checks by which no single compiler, machine or run is trusted: other compilers, sanitizers, random bytes, kills.
.PHONY: clang fuzz check-all check-threads check-memory check-clang check-arm check-interruptions check-nurbs

# The newest Clang here; without any, Debian's where it may be installed, else the sanitizers are of the package's compiler.
CLANG = $(shell ls /usr/bin/clang++ /usr/bin/clang++-[0-9]* 2> /dev/null | sort -V | tail -1)
clang:
	@[ -n "$(CLANG)" ] || \
	  { [ "$$(id -u)" = 0 ] && apt-get update -qq && apt-get install -y -qq --no-install-recommends clang-19 libclang-rt-19-dev; } > /dev/null || \
	  { echo "no Clang: the core's tests are run by one compiler only"; [ -z "$$CI" ]; }

# Builds the core's tests in build/NAME with CMake's further arguments, and runs them, by a prefix, half of them in each of two
# processes. Ninja does not share make's jobs.
comma := ,
define core_tests
$(BIN)/cmake -S . -B build/$(1) -G Ninja -DCMAKE_MAKE_PROGRAM=$(abspath $(BIN)/ninja) -DBOBROSSNET_TESTS=ON -DBOBROSSNET_WERROR=ON $(2)
MAKEFLAGS= $(BIN)/cmake --build build/$(1) && printf '1/2\n2/2\n' | xargs -n 1 -P 2 $(3) build/$(1)/core_tests
endef

# Random bytes into every door, TIME seconds for each target of the core and each format of files, or for TARGET=script alone;
# the sanitizers watch the core. What is found stays in build/fuzz.
TIME ?= 60
TARGET ?= *
fuzz: $(VENV)/installed-test clang
	$(BIN)/cmake -S . -B build/fuzz -G Ninja -DCMAKE_MAKE_PROGRAM=$(abspath $(BIN)/ninja) -DCMAKE_CXX_COMPILER=$(CLANG) -DBOBROSSNET_FUZZ=ON
	$(BIN)/cmake --build build/fuzz
	$(BIN)/python core/fuzz/run.py build/fuzz --seconds $(TIME) --target '$(TARGET)'
ifeq ($(TARGET),*)
	$(BIN)/python tests/fuzz/run.py --time $(TIME)
endif

# What takes too long for `make test`: threads under ThreadSanitizer, the Python module under the other sanitizers, Clang's
# code as it would ship, 64-bit ARM, work that is killed at random moments, full disks, files of other users.
check-all: check-threads check-memory check-clang check-arm check-interruptions check-nurbs

# The Python module in build/NAME/site, built with sanitizers; their libraries come before Python's own.
define sanitized_module
SKBUILD_BUILD_DIR=build/$(1) SKBUILD_CMAKE_DEFINE="BOBROSSNET_SANITIZE=$(2);BOBROSSNET_WASM=OFF" \
  $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --upgrade --target build/$(1)/site .
endef
sanitized = LD_PRELOAD="$(foreach l,$(1),$(shell $(CXX) -print-file-name=lib$(l).so))" PYTHONPATH=build/$(2)/site setarch -R $(BIN)/pytest -s -m "not measures"
ON_THREADS := tests/test_async_tracers.py tests/test_complete.py tests/test_custom.py tests/test_implicit.py tests/test_kernels.py \
  tests/test_light.py tests/test_motion.py tests/test_nurbs_tracing.py tests/test_progressive.py tests/test_scene.py tests/test_threads.py \
  tests/test_trace.py
IN_THE_CORE := $(ON_THREADS) tests/test_cases_of_meshes.py tests/test_channels.py tests/test_container.py tests/test_files.py \
  tests/test_formula.py tests/test_gbuffer.py tests/test_gltf.py tests/test_guided.py tests/test_mesh_word.py tests/test_nurbs.py tests/test_nurbs_basis.py tests/test_order.py tests/test_script.py tests/test_sdf.py

# GCC 12 finds faults in code that it has instrumented itself, so that its warnings are no errors here.
check-threads: $(VENV)/installed-test
	$(call core_tests,threads,-DBOBROSSNET_SANITIZE=thread -DBOBROSSNET_WERROR=OFF,setarch -R)
	$(call sanitized_module,threads-module,thread)
	TSAN_OPTIONS="halt_on_error=1 ignore_noninstrumented_modules=1" $(call sanitized,tsan,threads-module) $(ON_THREADS)

check-memory: $(VENV)/installed-test
	$(call sanitized_module,memory-module,address$(comma)undefined)
	ASAN_OPTIONS=detect_leaks=0 $(call sanitized,asan ubsan,memory-module) $(IN_THE_CORE)

check-clang: $(VENV)/installed-test clang
	$(call core_tests,clang,-DCMAKE_CXX_COMPILER=$(CLANG) -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DBOBROSSNET_UNITY=OFF)

# Debian: g++-aarch64-linux-gnu and qemu-user.
check-arm: $(VENV)/installed-test
	$(call core_tests,arm,-DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++,\
	  qemu-aarch64 -L /usr/aarch64-linux-gnu)

check-interruptions: $(VENV)/installed-test
	$(BIN)/pytest tests/checks

# NURBS of awkward kinds against points in double precision.
check-nurbs: $(VENV)/installed-test
	$(BIN)/python tests/nurbs_oracle.py
