# dynmeshd and dynmesh, built and run on Debian 12 from the packages in deploy/packages.txt.
#
#   docker build -t dynmesh .
#   docker run --rm -p 127.0.0.1:7878:7878 dynmesh
FROM debian:12 AS build
WORKDIR /src
# The packages change less often than the sources: a layer of their own.
COPY deploy/packages.txt deploy/install-packages deploy/
RUN deploy/install-packages build && rm -rf /var/lib/apt/lists/*
COPY . .
RUN cmake --preset release -DDYNMESH_TESTS=OFF -DDYNMESH_BENCHMARKS=OFF \
 && cmake --build --preset release --target dynmeshd dynmesh_cli \
 && strip build/release/bin/dynmeshd build/release/bin/dynmesh

FROM debian:12-slim
COPY deploy/packages.txt deploy/install-packages /tmp/deploy/
RUN /tmp/deploy/install-packages runtime && rm -rf /var/lib/apt/lists/* /tmp/deploy
COPY --from=build /src/build/release/bin/dynmeshd /src/build/release/bin/dynmesh /usr/local/bin/
COPY LICENSE /usr/share/doc/dynmesh/
RUN useradd --system --no-create-home --shell /usr/sbin/nologin dynmesh
USER dynmesh
EXPOSE 7878
# Within the container; what reaches it from outside is decided where it is run.
ENTRYPOINT ["dynmeshd"]
CMD ["--listen", "0.0.0.0:7878"]
HEALTHCHECK --interval=10s --timeout=5s --start-period=5s \
  CMD ["dynmesh", "stats", "--server", "127.0.0.1:7878"]
