# dynmeshd and dynmesh, built and run on Debian 12 from the packages in deploy/packages.txt.
#
#   docker build -t dynmesh .
#   docker run --rm --read-only --stop-timeout 30 -p 127.0.0.1:7878:7878 -v meshes:/var/lib/dynmesh dynmesh
#
# As it is, every client that reaches the container, from its network too, may do everything.
# What follows the image's name takes the place of that; certificate, key and tokens have to be
# readable for user 10001 (`dynmesh token` makes a token, and its line for the file):
#   docker run ... -v /etc/dynmesh:/etc/dynmesh:ro dynmesh --tls-cert /etc/dynmesh/server.pem \
#     --tls-key /etc/dynmesh/server.key --tokens /etc/dynmesh/tokens
FROM debian:12 AS build
WORKDIR /src
# The packages change less often than the sources: a layer of their own.
COPY deploy/packages.txt deploy/install-packages deploy/
RUN deploy/install-packages build && rm -rf /var/lib/apt/lists/*
COPY . .
RUN cmake --preset release -DDYNMESH_TESTS=OFF -DDYNMESH_BENCHMARKS=OFF -DDYNMESH_PYTHON=OFF \
 && cmake --build --preset release --target dynmeshd dynmesh_cli \
 && strip build/release/bin/dynmeshd build/release/bin/dynmesh

FROM debian:12-slim
COPY deploy/packages.txt deploy/install-packages /tmp/deploy/
RUN /tmp/deploy/install-packages runtime && rm -rf /var/lib/apt/lists/* /tmp/deploy
COPY --from=build /src/build/release/bin/dynmeshd /src/build/release/bin/dynmesh /usr/local/bin/
COPY LICENSE /usr/share/doc/dynmesh/
RUN groupadd --gid 10001 dynmesh \
 && useradd --uid 10001 --gid 10001 --no-create-home --shell /usr/sbin/nologin dynmesh \
 && install -d -o dynmesh -g dynmesh -m 700 /var/lib/dynmesh
USER 10001
VOLUME /var/lib/dynmesh
EXPOSE 7878 9178
# Within the container; what reaches it from outside is decided where it is run.
ENTRYPOINT ["dynmeshd", "--listen", "0.0.0.0:7878", "--data-dir", "/var/lib/dynmesh", \
            "--metrics", "0.0.0.0:9178"]
CMD ["--insecure-listen"]
HEALTHCHECK --interval=10s --timeout=5s --start-period=60s \
  CMD ["bash", "-c", "exec 3<>/dev/tcp/127.0.0.1/9178 && printf 'GET /healthz HTTP/1.0\\r\\n\\r\\n' >&3 && head -1 <&3 | grep -q ' 200 '"]
