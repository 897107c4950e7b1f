# Pictures, data and measures of shapes without a display:
#
#     docker build -t bobrossnet .
#     docker run --rm -v "$PWD:/work" bobrossnet thumbs models -o pictures
#     docker run --rm -i -v "$PWD:/work" bobrossnet mcp
#
# docs/how-to/programs.md states the size.

FROM debian:bookworm-slim AS build
RUN apt-get update \
    && apt-get install -y --no-install-recommends g++ python3-dev python3-venv
COPY . /source
# The page, which needs WebAssembly modules, is left out.
RUN python3 -m venv /opt/bobrossnet \
    && /opt/bobrossnet/bin/pip install --no-cache-dir -Ccmake.define.BOBROSSNET_WASM=OFF '/source[cad,mcp]' \
    && /opt/bobrossnet/bin/pip uninstall -y pip setuptools

FROM debian:bookworm-slim
# OpenCascade, which reads STEP and IGES, links to libGL, but draws nothing.
RUN apt-get update \
    && apt-get install -y --no-install-recommends libgl1 python3 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --create-home --uid 1000 bobrossnet
COPY --from=build /opt/bobrossnet /opt/bobrossnet
ENV PATH=/opt/bobrossnet/bin:$PATH
USER bobrossnet
WORKDIR /work
ENTRYPOINT ["bobrossnet"]
CMD ["--help"]
