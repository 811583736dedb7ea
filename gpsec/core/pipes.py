"""Pipes between processes: an end that is gone is an error of its own, apart from all else that a system refuses."""

from multiprocessing.connection import Connection
from typing import Any


class PeerGoneError(Exception):
    """Nobody is at the other end of a pipe any more."""


def send(connection: Connection, message: object) -> None:
    """Send a message.

    Raises:
        PeerGoneError: nobody will read it.
    """
    try:
        connection.send(message)
    except OSError:
        raise PeerGoneError from None


def receive(connection: Connection) -> Any:
    """Return the next message; what was sent before the other end closed comes first.

    Raises:
        PeerGoneError: there is none, and none will come.
    """
    try:
        return connection.recv()
    except (EOFError, OSError):
        raise PeerGoneError from None
