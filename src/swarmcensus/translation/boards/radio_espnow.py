import espnow
import network

CHANNEL = 1  # of Wi-Fi, 1 to 13: FILL IN the same one for all robots
EVERYBODY = b"\xff" * 6
BUFFER = 2048  # bytes of datagrams that wait for a tick


class Radio:
    """Broadcasts of ESP-NOW between boards with an ESP32. An ESP8266 sends them too, and receives none."""

    def __init__(self):
        """Switch the radio on: a restart of the program leaves Wi-Fi as it was."""
        for kind in (network.AP_IF, network.STA_IF):
            network.WLAN(kind).active(False)
        wifi = network.WLAN(network.STA_IF)
        wifi.active(True)
        quietly(wifi.disconnect)  # an ESP8266 goes to its last access point, on whatever channel
        try:
            wifi.config(channel=CHANNEL)
        except OSError:  # an ESP8266 takes a channel only as an access point
            point = network.WLAN(network.AP_IF)
            point.active(True)
            point.config(channel=CHANNEL)
            point.active(False)
        quietly(lambda: wifi.config(pm=wifi.PM_NONE))  # sleep would delay what others send
        self.now = espnow.ESPNow()
        self.sender = None  # of the last datagram
        self.watcher = EVERYBODY  # a gateway, once it has spoken
        self.open()

    def open(self):
        """Switch ESP-NOW on."""
        self.is_open = False
        self.now.active(False)
        self.now.config(rxbuf=BUFFER)
        self.now.active(True)
        self.now.add_peer(EVERYBODY)
        self.is_open = True

    def _try(self, method, *given):
        """Call a method; after an error, but for full buffers, the next call switches ESP-NOW on again."""
        if not self.is_open:
            network.WLAN(network.STA_IF).active(True)
            self.open()
        try:
            return method(*given)
        except Exception as error:
            self.is_open = "ESP_ERR_ESPNOW_NO_MEM" in error.args
            raise

    def send(self, datagram):
        """Broadcast once; a broadcast is not acknowledged."""
        self._try(self.now.send, EVERYBODY, datagram, False)

    def receive(self):
        """The next datagram, or None."""
        self.sender, datagram = self._try(self.now.recv, 0)
        return datagram

    def answer(self, datagram):
        """Send to the gateway alone, so that the buffers of robots have room for messages."""
        if self.watcher != EVERYBODY:
            quietly(lambda: self.now.add_peer(self.watcher))  # it may be known
        self._try(self.now.send, self.watcher, datagram, False)
