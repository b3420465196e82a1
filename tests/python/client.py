#!/usr/bin/env python3
"""A host for the device of shared/PROTOCOL.md: one episode in a simulated square room.

It opens a session, explores with random moves, starts learning, pursues the goal "avoid" for some
decisions and stops. Standard library only; written from that document alone. Exit codes: 0 the
episode is complete, 1 the device or the robot misbehaved, 2 wrong arguments or no connection.
"""

import argparse
import math
import socket
import time
import zlib

# Numbers of the grammar.
PROTOCOL, SENSORS, NEURONS = 2, 16, 16
SCHEMA = 0xe129e7ff

HELLO, SCAN, ODOMETRY, COMMAND, COUNTERS = 0, 2, 3, 4, 7
GOAL, EXPLORE, LEARN, SEEK, STOP, FORGET = 0, 1, 2, 3, 4, 6
AVOID = 0
MOVING, ENDED = 0, 1
IDLE, STOPPED = 0, 4
REPORTS = ["Hello", "Motion", "Decision", "Mode", "Counters", "Refusal", "Chunk", "Parameter", "Log", "Done"]
REPEAT_S, ATTEMPTS, LEARNING_S = 0.5, 60, 300
TTL_MS, SEED, MOVES, DECISIONS = 1000, 1, 20, 20


class ProtocolError(Exception):
    pass


def varint(value):
    """An unsigned integer, 7 bits per byte, lowest first."""
    return bytes([value]) if value < 0x80 else bytes([value & 0x7F | 0x80]) + varint(value >> 7)


def zigzag(value):
    """A signed integer."""
    return varint(2 * value if value >= 0 else -2 * value - 1)


class Reader:
    """The fields of a message, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def byte(self):
        self.at += 1
        return self.data[self.at - 1]

    def varint(self):
        byte = self.byte()
        return byte if byte < 0x80 else byte & 0x7F | self.varint() << 7

    def zigzag(self):
        value = self.varint()
        return value // 2 if value % 2 == 0 else -(value + 1) // 2


def cobs_encode(data):
    """COBS for at most 254 bytes: each zero becomes the distance to the next one."""
    return b"".join(bytes([len(group) + 1]) + group for group in data.split(b"\0"))


def cobs_decode(coded):
    data = bytearray()
    while coded:
        data += coded[1 : coded[0]] + b"\0"
        coded = coded[coded[0] :]
    return bytes(data[:-1])


def checksum(data):
    return zlib.crc32(data).to_bytes(4, "little")


def pack(session, seq, message):
    body = varint(session) + varint(seq) + message
    return cobs_encode(body + checksum(body)) + b"\0"


def unpack(coded):
    """Session, seq and report of a frame without delimiter; None for a damaged or empty one."""
    data = cobs_decode(coded)
    if not coded or checksum(data[:-4]) != data[-4:]:
        return None
    reader = Reader(data[:-4])
    return reader.varint(), reader.varint(), report(reader)


def report(reader):
    """The fields that this host needs; for other messages only the kind."""
    _device_ms, kind = reader.varint(), reader.varint()
    reply = {"kind": REPORTS[kind] if kind < len(REPORTS) else kind}
    if reply["kind"] == "Hello":
        reply["dimensions"] = [reader.varint(), reader.varint(), reader.byte(), reader.byte()]
    elif reply["kind"] == "Motion":
        reply["id"], reply["revision"] = reader.varint(), reader.byte()
        reply["dx"], reply["dy"], reply["speed"] = reader.zigzag(), reader.zigzag(), reader.varint()
    elif reply["kind"] == "Mode":
        reply["mode"] = reader.varint()
    elif reply["kind"] == "Counters":
        reply["counts"] = [reader.varint() for _ in range(13)]
    elif reply["kind"] == "Refusal":
        reply["seq"], reply["reason"] = reader.varint(), reader.varint()
    elif reply["kind"] == "Done":
        reply["seq"] = reader.varint()
    return reply


class Link:
    """Session, requests and their retransmission."""

    def __init__(self, host, port):
        self.socket = socket.create_connection((host, port), timeout=10)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.received = bytearray()
        # A new number at each start, never 0.
        self.session, self.seq = time.time_ns() // 1_000_000 % 65_535 + 1, 0
        self.device_seq = 0

    def reports(self, seconds):
        """Reports of this session until a timeout; a refused Hello is answered in the previous one."""
        until = time.monotonic() + seconds
        while True:
            coded, zero, rest = self.received.partition(b"\0")
            if zero:
                self.received = rest
                frame = unpack(coded)
                if frame is not None and self.is_news(*frame):
                    yield frame[2]
                continue
            self.socket.settimeout(max(until - time.monotonic(), 0.001))
            try:
                data = self.socket.recv(4096)
            except socket.timeout:
                return
            if not data:
                raise ProtocolError("the device closed the connection")
            self.received += data

    def is_news(self, session, seq, reply):
        """The next new report of this session; fails if one is missing."""
        if session != self.session:
            return reply["kind"] == "Refusal"
        ahead = (seq - self.device_seq) % 65_536
        if 1 < ahead < 32_768:
            raise ProtocolError(f"{ahead - 1} reports are missing before number {seq}")
        self.device_seq = seq if ahead == 1 else self.device_seq
        return ahead == 1

    def request(self, message):
        """Sends a message and returns the reports up to its end; resends the same bytes meanwhile."""
        self.seq = (self.seq + 1) % 65_536
        frame, answer = pack(self.session, self.seq, message), []
        for _ in range(ATTEMPTS):
            self.socket.sendall(b"\0" + frame)
            for reply in self.reports(REPEAT_S):
                # A Hello is answered by a Hello, everything else ends with Done.
                if message[0] == HELLO and reply["kind"] == "Hello":
                    return [reply]
                if reply["kind"] == "Done" and reply["seq"] == self.seq:
                    return answer
                if reply["kind"] == "Refusal" and reply["seq"] == self.seq:
                    raise ProtocolError(f"request {message[0]} is refused for reason {reply['reason']}")
                answer.append(reply)
        raise ProtocolError(f"no answer to request {message[0]}")

    def hello(self):
        dimensions = varint(PROTOCOL) + varint(SCHEMA) + bytes([SENSORS, NEURONS])
        host_clock, open_space = 0, 0
        [reply] = self.request(bytes([HELLO]) + dimensions + bytes([host_clock, open_space]))
        if reply["dimensions"] != [PROTOCOL, SCHEMA, SENSORS, NEURONS]:
            raise ProtocolError(f"the device has other dimensions: {reply['dimensions']}")


class Robot:
    """A holonomic base below a ring that keeps its bearing, in a square room of 4 m by 4 m."""

    HALF_MM, FACE_MM, BODY_MM = 2_000, 231, 269
    STEP_MS, SENSORS_PER_STEP = 160, 4

    def __init__(self, link):
        self.link, self.now_ms = link, 0
        self.x, self.y, self.motion = 300, -200, None
        self.next_sensor, self.decisions, self.mode, self.nearest = 0, 0, IDLE, self.HALF_MM

    def range_mm(self, sensor):
        """The range from a transducer's face to the wall."""
        angle = 2 * math.pi * sensor / SENSORS
        parts = (self.x, math.cos(angle)), (self.y, math.sin(angle))
        ways = [(math.copysign(self.HALF_MM, part) - place) / part for place, part in parts if abs(part) > 1e-9]
        return max(round(min(ways)) - self.FACE_MM, 0)

    def obey(self, answer):
        for reply in answer:
            if reply["kind"] == "Motion":
                self.take(reply)
            elif reply["kind"] == "Mode":
                self.mode = reply["mode"]
            elif reply["kind"] == "Decision":
                self.decisions += 1

    def take(self, order):
        """A newer or shorter motion replaces the rest of the present one; the same one renews it."""
        if self.motion is not None:
            newer = (order["id"] - self.motion["id"]) % 65_536
            shorter = (order["revision"] - self.motion["revision"]) % 256
            if newer >= 32_768 or newer == 0 and (shorter == 0 or shorter >= 128):
                return
        self.motion = dict(order, open=True)

    def order(self, order):
        times = varint(self.now_ms) + varint(TTL_MS)
        self.obey(self.link.request(bytes([COMMAND]) + times + order))

    def drive(self):
        """Rolls for a step and reports it incrementally, once with Ended, also for (0, 0)."""
        motion = self.motion
        length = math.hypot(motion["dx"], motion["dy"])
        share = 1 if length == 0 else min(1, motion["speed"] * self.STEP_MS / 1000 / length)
        dx, dy = round(motion["dx"] * share), round(motion["dy"] * share)
        self.x, self.y = self.x + dx, self.y + dy
        motion["dx"], motion["dy"] = motion["dx"] - dx, motion["dy"] - dy
        self.nearest = min(self.nearest, self.HALF_MM - max(abs(self.x), abs(self.y)))
        if self.nearest < self.BODY_MM:
            raise ProtocolError(f"the robot touches the wall at ({self.x}, {self.y})")
        motion["open"] = share < 1
        turned, progress = 0, MOVING if motion["open"] else ENDED
        report = varint(self.now_ms) + varint(motion["id"]) + zigzag(dx) + zigzag(dy) + varint(turned)
        self.obey(self.link.request(bytes([ODOMETRY]) + report + bytes([progress])))

    def listen(self):
        """The next transducers of the ring."""
        echoes = b""
        for _ in range(self.SENSORS_PER_STEP):
            range_mm = self.range_mm(self.next_sensor)
            echoes += bytes([self.next_sensor, 1]) + varint(range_mm) + varint(0)
            self.next_sensor = (self.next_sensor + 1) % SENSORS
        message = bytes([SCAN]) + varint(self.now_ms) + varint(self.SENSORS_PER_STEP) + echoes
        self.obey(self.link.request(message))

    def step(self):
        """160 ms: below the timeout of 300 ms, four steps per ring of 640 ms."""
        self.now_ms += self.STEP_MS
        if self.motion is not None and self.motion["open"]:
            self.drive()
        self.listen()
        if self.mode == STOPPED:
            raise ProtocolError("the robot has stopped by itself")


def episode(link):
    link.hello()
    robot = Robot(link)
    robot.order(bytes([FORGET]))
    robot.order(bytes([EXPLORE]) + varint(MOVES) + varint(SEED))
    while robot.mode != IDLE:
        robot.step()
    explored = robot.decisions
    robot.order(bytes([LEARN]))
    for reply in link.reports(LEARNING_S):
        robot.obey([reply])
        if robot.mode == IDLE:
            break
    else:
        raise ProtocolError(f"the maps are not made in {LEARNING_S} s")
    robot.order(bytes([GOAL, AVOID]))
    robot.order(bytes([SEEK]))
    while robot.decisions < explored + DECISIONS:
        robot.step()
    robot.order(bytes([STOP]))
    if robot.mode != STOPPED:
        raise ProtocolError(f"the mode after a stop is {robot.mode}")
    [counters] = [reply["counts"] for reply in link.request(bytes([COUNTERS])) if reply["kind"] == "Counters"]
    if any(counters[1:5]) or counters[12] != 0:
        raise ProtocolError(f"frames or echoes were not taken: {counters}")
    print(f"nearest to a wall: {robot.nearest} mm from the center, after {robot.now_ms} simulated ms")
    return f"explored {explored} moves, learned, took {robot.decisions - explored} decisions, stopped"


def main():
    parser = argparse.ArgumentParser(description="One episode with the device at HOST:PORT.")
    parser.add_argument("address", metavar="HOST:PORT")
    address = parser.parse_args().address
    host, colon, port = address.rpartition(":")
    if not colon or not port.isdecimal():
        parser.error(f"{address} is no HOST:PORT")
    try:
        print(episode(Link(host, int(port))))
    except ProtocolError as error:
        parser.exit(1, f"client.py: {error}\n")
    except OSError as error:
        parser.exit(2, f"client.py: {address}: {error}\n")


if __name__ == "__main__":
    main()
