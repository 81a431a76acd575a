import errno
import socket

WIFI = ("name of the network", "password")  # FILL IN; boards without the module `network` need none
EVERYBODY = ("255.255.255.255", 47230)  # address and port
JOINING = 20000  # milliseconds from one try to join the network to the next
FULL = (errno.EAGAIN, errno.ENOMEM, errno.ETIMEDOUT)  # nothing waits, or there is no room


class Radio:
    """Datagrams over UDP, to all robots of the network. While the network is away, the robot goes on alone."""

    def __init__(self):
        """Switch Wi-Fi on; the first call joins the network, and nobody waits for it."""
        self.socket = self.wifi = None
        self.tried = None  # when it last asked for the network, while that is away
        self.has_asked = False
        try:
            import network
        except ImportError:
            return
        self.wifi = network.WLAN(network.STA_IF)
        self.wifi.active(True)

    def _join(self):
        """Raise OSError unless the network is there; ask for it from time to time."""
        if self.has_asked and self.wifi.isconnected():
            self.tried = None
            return
        if self.socket:
            self._close()
        if self.tried is None or not 0 <= since(clock(), self.tried) < JOINING:
            self.tried, self.has_asked = clock(), True
            quietly(self.wifi.disconnect)  # from another network, or from a try that would refuse this one
            self.wifi.connect(*WIFI)
        raise OSError("no network")

    def _ready(self):
        if self.wifi:
            self._join()
        if not self.socket:
            made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            try:
                self._set_up(made)
            except Exception:
                made.close()
                raise
            self.socket = made
        return self.socket

    def _set_up(self, made):
        if self.wifi:
            quietly(lambda: self.wifi.config(pm=self.wifi.PM_NONE))  # sleep would delay what others send
        for option in ("SO_REUSEADDR", "SO_BROADCAST"):
            if hasattr(socket, option):
                made.setsockopt(socket.SOL_SOCKET, getattr(socket, option), 1)
        made.bind(socket.getaddrinfo("0.0.0.0", EVERYBODY[1])[0][-1])
        made.setblocking(False)
        self.address = socket.getaddrinfo(*EVERYBODY)[0][-1]

    def _close(self):
        closed, self.socket = self.socket, None
        closed.close()

    def _try(self, method, *given):
        """Call a method of the socket; None where nothing waits, or there is no room."""
        try:
            return method(*given)
        except OSError as error:
            if error.args and error.args[0] in FULL:
                return None
            raise

    def send(self, datagram):
        """Broadcast once; a socket that cannot send stays open, because it may hear."""
        self._try(self._ready().sendto, datagram, self.address)

    def receive(self):
        """The next datagram, or None; after an error the next call makes a new socket."""
        try:
            got = self._try(self._ready().recvfrom, 2048)
        except Exception:
            if self.socket:
                self._close()
            raise
        return got and got[0]
