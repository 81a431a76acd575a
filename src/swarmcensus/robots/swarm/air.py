"""The air between robots that are processes.

What becomes of a message is decided where it arrives, by a hash of who sent it, when, and who hears it. So a run's
losses are known afterwards.
"""

MASK = 0xFFFFFFFF
LOSS, DUPLICATE, JITTER, LUCK, PHASE, DRIFT = range(6)  # what a hash is for
AT_ONCE = 255  # datagrams that are taken from the socket at a time
WAITING = 2000  # datagrams that wait to be heard, at most


def share(seed, purpose, sender=0, boot=0, tick=0, receiver=0):
    """A number in [0, 1), a multiple of 2^-32: MurmurHash3 of two words. Boots have 8 bits, the others 16."""
    words = ((purpose << 24) | ((boot & 0xFF) << 16) | (sender & 0xFFFF), ((receiver & 0xFFFF) << 16) | (tick & 0xFFFF))
    h = seed & MASK
    for word in words:
        k = (word * 0xCC9E2D51) & MASK
        k = (((k << 15) | (k >> 17)) * 0x1B873593) & MASK
        h ^= k
        h = ((((h << 13) | (h >> 19)) & MASK) * 5 + 0xE6546B64) & MASK
    h ^= 4 * len(words)
    h = ((h ^ (h >> 16)) * 0x85EBCA6B) & MASK
    h = ((h ^ (h >> 13)) * 0xC2B2AE35) & MASK
    return (h ^ (h >> 16)) / 4294967296.0


class Air:
    """A robot's radio: sends over a socket to those who hear it, and loses, delays and doubles what arrives.

    socket: of datagrams, which never waits. messages: the robot's `Messages`, which tell noise apart. now: a function
    that returns milliseconds. number: of this robot. seed: of the hashes. loss, duplicate: shares of messages. delay:
    milliseconds. `hearers` are addresses of sockets.
    """

    def __init__(self, socket, messages, now, number, seed, loss=0.0, duplicate=0.0, delay=0):
        """Nobody hears it yet."""
        self.socket = socket
        self.messages = messages
        self.now = now
        self.number = number
        self.seed = seed
        self.loss = loss
        self.duplicate = duplicate
        self.delay = delay
        self.hearers = []
        self.waiting = []  # datagrams, each with the time from which it is heard
        self.sent = 0  # messages, each counted for each robot that should hear it
        self.lost = 0
        self.late = 0  # messages that came when the robot had ended

    def send(self, datagram):
        """Send to all who hear this robot."""
        self.sent += len(self.hearers)
        for address in self.hearers:
            try:
                self.socket.sendto(datagram, address)
            except (OSError, OverflowError):
                pass  # a full socket loses a message, as a full radio does

    def receive(self):
        """The next datagram that may be heard, or None."""
        if not self.waiting:
            self.listen()
        if self.waiting and self.waiting[0][0] <= self.now():
            return self.waiting.pop(0)[1]
        return None

    def listen(self):
        """Take what has arrived from the socket."""
        heard_from = self.now() + self.delay
        for _ in range(AT_ONCE):
            try:
                datagram = self.socket.recvfrom(self.messages.size + 1)[0]  # a longer one is noise
            except OSError:  # nothing has arrived
                break
            times = self.times(datagram)
            if not times:
                self.lost += self.messages.unpack(datagram) is not None
            elif len(self.waiting) < WAITING:
                self.waiting.extend([(heard_from, datagram)] * times)

    def times(self, datagram):
        """How often a datagram is heard: 0 if it is lost, 2 if it is doubled. Noise is heard once, and then refused."""
        if len(datagram) != self.messages.size or datagram[0] != self.messages.mark & 0xFF:
            return 1
        boot, sender, tick = datagram[1], datagram[2] | (datagram[3] << 8), datagram[4] | (datagram[5] << 8)
        if self.loss and share(self.seed, LOSS, sender, boot, tick, self.number) < self.loss:
            return 0
        if self.duplicate and share(self.seed, DUPLICATE, sender, boot, tick, self.number) < self.duplicate:
            return 2
        return 1

    def end(self):
        """Count what arrives after the robot's last tick."""
        self.listen()
        self.late += len(self.waiting)
        self.waiting = []
