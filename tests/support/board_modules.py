"""Stand-ins for the modules of boards with MicroPython, which fail where its documentation says that they may."""

FAKE = """
import sys

class Line:
    def __init__(self):
        self.data = b""
        self.other = self

    def any(self):
        return len(self.data)

    def read(self, count):
        out, self.data = self.data[:count], self.data[count:]
        return out

    def write(self, data):
        self.other.data += bytes(data)

class UART(Line):
    made = []

    def __init__(self, *_, **__):
        Line.__init__(self)
        UART.made.append(self)
        if len(UART.made) == 2:
            self.other, self.other.other = UART.made[0], self

class Pin:
    def __init__(self, number):
        pass

class ADC:
    state = 5

    def __init__(self, pin):
        pass

    def read_u16(self):
        ADC.state = (ADC.state * 75 + 74) % 65537
        return ADC.state % 65536

def unique_id():
    return b"board"
"""
FAKE_NOW = """
class ESPNow:
    made = []
    worn = False  # whether its buffers are full

    def __init__(self):
        self.box, self.peers, self.on = [], [], False
        ESPNow.made.append(self)

    def config(self, rxbuf):
        assert not self.on

    def active(self, on):
        self.on = on
        if not on:
            self.peers = []

    def check(self):
        if not self.on:
            raise OSError(12389, "ESP_ERR_ESPNOW_NOT_INIT")

    def add_peer(self, mac):
        self.check()
        if mac in self.peers:
            raise OSError(12395, "ESP_ERR_ESPNOW_EXIST")
        self.peers.append(mac)

    def send(self, mac, data, sync):
        self.check()
        if mac not in self.peers or len(data) > 250 or sync:
            raise OSError(12393, "ESP_ERR_ESPNOW_NOT_FOUND")
        if ESPNow.worn:
            raise OSError(12391, "ESP_ERR_ESPNOW_NO_MEM")
        for other in ESPNow.made:
            if other is not self:
                other.box.append((b"sender", data))

    def recv(self, timeout):
        self.check()
        return self.box.pop(0) if self.box and timeout == 0 else (None, None)
"""
FAKE_NETWORK = """
STA_IF, AP_IF = 0, 1
fails = set()  # the methods that raise
calls = []  # with what was given to them

class WLAN:
    PM_NONE = 0
    connected = False  # as after a soft reset, which leaves Wi-Fi as it was

    def __init__(self, kind):
        self.kind = kind
        call("WLAN", kind)

    def active(self, on):
        call("active", self.kind, on)

    def disconnect(self):
        WLAN.connected = False
        call("disconnect", self.kind)

    def connect(self, *wifi):
        call("connect", self.kind)

    def isconnected(self):
        call("isconnected", self.kind)
        return WLAN.connected

    def config(self, **given):
        for name in given:
            call(name, self.kind, given[name])

def call(name, *given):
    calls.append((name,) + given)
    if (name,) + given[:1] in fails or (name,) in fails:
        raise OSError("Wifi Internal Error")
"""
MODULES = {"machine.py": FAKE, "espnow.py": FAKE_NOW, "network.py": FAKE_NETWORK}

LOOPBACK_MACHINE = """
from espnow import ESPNow

class Pin:
    def __init__(self, number):
        pass

class ADC(Pin):
    def read_u16(self):
        return 0  # black

class UART:
    def __init__(self, *_, **__):
        self.now, self.data = ESPNow(), b""

    def any(self):
        self.data += self.now.recv(0)[1] or b""
        return len(self.data)

    def read(self, count):
        out, self.data = self.data[:count], self.data[count:]
        return out

    def write(self, data):
        self.now.send(b"", data, False)
"""
LOOPBACK_NOW = """
import socket

class ESPNow:
    def __init__(self):
        self.sockets = []
        for address in (("127.0.0.1", 0), ("", PORT)):
            self.sockets.append(one := socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            for option in (socket.SO_BROADCAST, socket.SO_REUSEADDR):
                one.setsockopt(socket.SOL_SOCKET, option, 1)
            one.bind(address)
            one.setblocking(False)
        self.peers = [b"\\xff" * 6, b""]

    def config(self, rxbuf):
        pass

    def active(self, on):
        pass

    def add_peer(self, mac):
        self.peers.append(mac)

    def send(self, mac, data, sync):
        assert mac in self.peers and len(data) <= 250
        to = ("127.0.0.1", int.from_bytes(mac, "big")) if len(mac) == 2 else ("127.255.255.255", PORT)
        self.sockets[0].sendto(data, to)

    def recv(self, timeout):
        for one in self.sockets:
            try:
                while True:
                    data, (_, port) = one.recvfrom(300)
                    if port != self.sockets[0].getsockname()[1]:
                        return port.to_bytes(2, "big"), data
            except BlockingIOError:
                pass
        return None, None
"""
# between processes
ON_LOOPBACK = {"machine.py": LOOPBACK_MACHINE, "espnow.py": LOOPBACK_NOW, "network.py": FAKE_NETWORK}
