"""A node on python-can's virtual bus that serves a fake drive in its own thread."""

import threading

import can

STOP = 0x7FF  # no drive here uses this identifier


class CanNode:
    """Calls take(message) for each frame from `channel`, until finish or close. A subclass calls __init__ when it is ready for frames."""

    def __init__(self, channel):
        self.bus = can.Bus(interface="virtual", channel=channel)
        self.thread = threading.Thread(target=self._serve, daemon=True)
        self.thread.start()

    def _serve(self):
        while (message := self.bus.recv()).arbitration_id != STOP:
            self.take(message)

    def send(self, identifier, data, **options):
        self.bus.send(can.Message(**{"arbitration_id": identifier, "data": data, "is_extended_id": False, **options}))

    def finish(self):
        """Handles the frames that are already on the bus, then stops."""
        if self.thread.is_alive():
            with can.Bus(interface="virtual", channel=self.bus.channel_id) as other:
                other.send(can.Message(arbitration_id=STOP, is_extended_id=False))
                self.thread.join()

    def close(self):
        self.finish()
        self.bus.shutdown()
