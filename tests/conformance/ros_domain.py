"""A ROS domain for each test process, so that two at the same time do not meet."""

import atexit
import os
import socket

DOMAINS = 100
"""Ports of domains above 101 meet those that Linux gives out."""


def claim_domain() -> int:
    """Return a domain that belongs to this process until it ends, as does the one after it.

    The claim is the TCP port with the number of the domain's first UDP port. DDS uses UDP only, and
    the kernel takes the claim back from a process that was killed, too.
    """
    for offset in range(DOMAINS // 2):
        domain = 1 + 2 * ((os.getpid() + offset) % (DOMAINS // 2))
        claim = socket.socket()
        try:
            claim.bind(("127.0.0.1", 7400 + 250 * domain))
        except OSError:
            claim.close()
            continue
        # What is to be done at the end also keeps the claim until then.
        atexit.register(claim.close)
        return domain
    raise RuntimeError(f"test processes have claimed all {DOMAINS} ROS domains")
