import espnow
import network

EVERYBODY = b"\xff" * 6


class Radio:
    """Broadcasts of ESP-NOW, between boards with an ESP32 or ESP8266. All robots need the same channel of Wi-Fi."""

    def __init__(self):
        """Switch the radio on."""
        wifi = network.WLAN(network.STA_IF)
        wifi.active(True)
        self.now = espnow.ESPNow()
        self.now.config(rxbuf=2048)  # bytes of datagrams that wait for a tick
        self.now.active(True)
        self.now.add_peer(EVERYBODY)

    def send(self, datagram):
        """Broadcast once; a broadcast is not acknowledged."""
        self.now.send(EVERYBODY, datagram, False)

    def receive(self):
        """The next datagram, or None."""
        return self.now.recv(0)[1]
