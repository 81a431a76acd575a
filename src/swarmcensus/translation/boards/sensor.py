# ============================== FILL IN: YOUR SENSOR ==============================
# `start` makes it ready: at the beginning, and again after `read` has raised. `read` returns True for black, False for
# white, None for no reading. The example is a light sensor at an analogue pin, which gives 0 to 65535.
PIN = 34
THRESHOLD = 30000  # black is darker than this


class Sensor:
    """Tells black from white."""

    def start(self):
        """Set up the pin."""
        import machine

        self.adc = machine.ADC(machine.Pin(PIN))
        if hasattr(machine.ADC, "ATTN_11DB"):  # an ESP32 measures up to 1 V otherwise
            self.adc.atten(machine.ADC.ATTN_11DB)

    def read(self):
        """One reading."""
        return self.adc.read_u16() < THRESHOLD


# ==================================================================================
