# Wheels for all platforms, and their checks: see docs/platforms.md.
.PHONY: wheels check-wheels

# Pythons of this machine that have the stable ABI of the wheels: the first one builds, each of them tries what was built.
PYTHONS ?= $(wildcard $(foreach v,3.12 3.13 3.14,/usr/bin/python$(v) /usr/local/bin/python$(v) $(HOME)/.pyenv/versions/$(v).*/bin/python$(v)))
RELEASE := build/wheels/venv

$(RELEASE)/tools: release/requirements.txt
	@[ -n "$(PYTHONS)" ] || { echo "wheels: expected Python 3.12 or later with its headers, got none; install one, or set PYTHONS=/path/of/python3.12"; exit 1; }
	$(firstword $(PYTHONS)) -m venv $(RELEASE)
	$(RELEASE)/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	@touch $@

# dist/*.whl and dist/*.tar.gz. TAG=win_amd64 builds one wheel alone; MODULES=DIR has the WebAssembly modules already.
TAG ?=
MODULES ?=
wheels: $(RELEASE)/tools
	$(RELEASE)/bin/python release/wheels.py $(addprefix --modules ,$(MODULES)) $(TAG)

# Debian: musl, qemu-user, wine64. Without them, the lines of what was not run name them.
check-wheels: $(VENV)/installed $(RELEASE)/tools
	@[ "$$(id -u)" != 0 ] || { apt-get update -qq && apt-get install -y -qq --no-install-recommends musl qemu-user wine64; } > /dev/null
	$(RELEASE)/bin/python release/check.py $(addprefix --python ,$(PYTHONS)) $(TAG)
