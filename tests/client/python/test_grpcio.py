"""The client over grpcio, where a server does not answer, a channel is closed, threads share it."""
import concurrent.futures
import threading
import time

import grpc
import pytest

import dynmesh
from dynmesh import _batch
from dynmesh._grpcio import Client, _Servers
from dynmesh.v1 import mesh_pb2


class SilentServer(grpc.GenericRpcHandler):
    """Has each mesh; takes edits and watches, and says nothing."""

    def service(self, details):
        if details.method.endswith("/GetMesh"):
            return grpc.unary_unary_rpc_method_handler(
                lambda request, context: mesh_pb2.Mesh().SerializeToString())
        if details.method.endswith("/EditStream"):
            return grpc.stream_stream_rpc_method_handler(self.wait)
        if details.method.endswith("/Watch"):
            return grpc.unary_stream_rpc_method_handler(self.wait)
        return None

    @staticmethod
    def wait(request, context):
        while context.is_active():
            time.sleep(0.02)
        yield from ()


@pytest.fixture
def silent():
    server = grpc.server(concurrent.futures.ThreadPoolExecutor(4))
    server.add_generic_rpc_handlers([SilentServer()])
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    yield f"127.0.0.1:{port}"
    assert server.stop(None).wait(60), "a server does not end"


def test_a_large_batch_has_the_timeout_of_a_small_one(silent):
    client = Client(silent, "", "", "", "", 0.5, False)
    points = {i: (i * 1e-6, 0.5) for i in range(1, 30_001)}  # more than a message
    batch = _batch.make(2, {"add_points": points})
    answer = []
    thread = threading.Thread(target=lambda: answer.append(refused(
        lambda: client.apply("plate", batch, "", None, False))), daemon=True)
    thread.start()
    thread.join(60)
    assert answer and isinstance(answer[0], dynmesh.errors.DeadlineExceeded)


def refused(call):
    with pytest.raises(dynmesh.DynmeshError) as caught:
        call()
    return caught.value


def test_a_stream_whose_channel_is_closed_says_so(silent):
    client = Client(silent, "", "", "", "", 0, False)
    stream = client.stream("plate", 0, "0" * 32, True, 60)
    try:
        assert stream.next(0.2) is None
        client._servers.channel(silent).close()
        for _ in range(2):  # the second time, too
            with pytest.raises(dynmesh.DynmeshError, match="the stream ended"):
                assert stream.next(60) is not None
    finally:
        stream.cancel()


class SlowDict(dict):
    """Another thread goes on after each read."""

    def get(self, *arguments):
        got = super().get(*arguments)
        time.sleep(1e-4)
        return got

    def __setitem__(self, key, value):
        assert value >= super().get(key, 0)
        super().__setitem__(key, value)


class SlowSet(set):
    """The same."""

    def __contains__(self, key):
        has = super().__contains__(key)
        time.sleep(1e-2)
        return has


def in_threads(function, count=4):
    with concurrent.futures.ThreadPoolExecutor(count) as threads:
        list(threads.map(function, range(count)))


def test_what_threads_saw_does_not_go_back():
    client = Client("127.0.0.1:1", "", "", "", "", 0, True)
    client._seen = SlowDict()

    def see(thread):
        for revision in range(thread, 400, 4):
            client._saw("plate", revision)

    in_threads(see)
    assert client._seen == {"plate": 399}


def test_a_return_of_a_server_is_counted_once():
    client = Client("127.0.0.1:1", "", "", "", "", 0, False)
    servers = client._servers
    servers._failed = SlowSet(["127.0.0.1:1"])
    in_threads(lambda _: servers._changed("127.0.0.1:1", grpc.ChannelConnectivity.READY))
    assert client.servers_returned() == 1


class PolledChannel:
    """As gRPC's, where a thread asks for its state for some time after the last watch has ended."""

    def __init__(self):
        self._connectivity_state = self
        self.polling = False
        self.watches = []
        self.was_polled = None

    def subscribe(self, callback):
        self.watches.append(callback)
        self.polling = True

    def unsubscribe(self, callback):
        self.watches.remove(callback)
        threading.Timer(0.2, lambda: setattr(self, "polling", False)).start()

    def close(self):
        self.was_polled = self.polling


def test_a_channel_is_closed_when_its_state_is_no_longer_asked_for(monkeypatch):
    channel = PolledChannel()
    monkeypatch.setattr(grpc, "insecure_channel", lambda *_: channel)
    servers = _Servers("127.0.0.1:1", None, False)
    assert servers.channel("127.0.0.1:1") is channel and len(channel.watches) == 1
    servers.close()
    assert not channel.watches and channel.was_polled is False
