#!/usr/bin/env python3
"""Runs a program against a dynmeshd of its own, on a port that the system chose.

    run_with_server.py DYNMESHD PROGRAM [ARGUMENT...]

The program gets `--server HOST:PORT` as well. It is to end with 0 and its last line is to be
"good"; the server, told to end, is to end with 0, too.
"""
import pathlib
import subprocess
import sys
import tempfile
import time


def address_of(server, port_file):
    """Waits until the server listens."""
    until = time.monotonic() + 60
    while not port_file.exists() or not port_file.read_text():
        if server.poll() is not None:
            sys.exit(f"the server ended with {server.returncode}")
        if time.monotonic() > until:
            sys.exit("no server after 60 s")
        time.sleep(0.02)
    return f"127.0.0.1:{int(port_file.read_text())}"


def main():
    daemon, *program = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        port_file = pathlib.Path(folder) / "port"
        server = subprocess.Popen([daemon, "--listen", "127.0.0.1:0", "--port-file", port_file],
                                  stdout=subprocess.DEVNULL)
        try:
            done = subprocess.run([*program, "--server", address_of(server, port_file)],
                                  stdout=subprocess.PIPE, text=True, check=False, timeout=600)
            print(done.stdout, end="", flush=True)
        finally:
            server.terminate()
            ended = server.wait(60)
    if done.returncode != 0:
        sys.exit(f"the program ended with {done.returncode}")
    if done.stdout.splitlines()[-1:] != ["good"]:
        sys.exit("the program's last line is not: good")
    if ended != 0:
        sys.exit(f"the server ended with {ended}")


if __name__ == "__main__":
    main()
