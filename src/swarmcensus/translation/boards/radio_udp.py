import errno
import socket

WIFI = ("name of the network", "password")  # FILL IN; boards without the module `network` need none
EVERYBODY = ("255.255.255.255", 47230)  # address and port


class Radio:
    """Datagrams over UDP, to all robots of the network. While the network is away, the robot goes on alone."""

    def __init__(self):
        """Join the network, without waiting for it."""
        self.socket = None
        try:
            import network
        except ImportError:
            self.wifi = None
        else:
            self.wifi = network.WLAN(network.STA_IF)
            self.wifi.active(True)
            self.wifi.connect(*WIFI)

    def _ready(self):
        if self.wifi and not self.wifi.isconnected():
            raise OSError("no network")
        if not self.socket:
            made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            for option in ("SO_REUSEADDR", "SO_BROADCAST"):
                if hasattr(socket, option):
                    made.setsockopt(socket.SOL_SOCKET, getattr(socket, option), 1)
            made.bind(socket.getaddrinfo("0.0.0.0", EVERYBODY[1])[0][-1])
            made.setblocking(False)
            self.address = socket.getaddrinfo(*EVERYBODY)[0][-1]
            self.socket = made
        return self.socket

    def _try(self, method, *given):
        """Call a method of the socket; after an error the next call makes a new one."""
        try:
            return method(*given)
        except OSError as error:
            if error.args and error.args[0] == errno.EAGAIN:  # nothing waits, or there is no room
                return None
            self.socket.close()
            self.socket = None
            raise

    def send(self, datagram):
        """Broadcast once."""
        self._try(self._ready().sendto, datagram, self.address)

    def receive(self):
        """The next datagram, or None."""
        got = self._try(self._ready().recvfrom, 2048)
        return got and got[0]
