"""Runs a command and prints, as a line of JSON, what the operating system says that it used.

    launch.py COMMAND [ARGUMENT …]

A process's peak of memory counts what its parent held when it was started, so that a large program cannot measure a small one: this one is small.
"""

import json
import os
import sys
import time

start = time.monotonic()
pid = os.posix_spawnp(sys.argv[1], sys.argv[1:], os.environ)
_, status, used = os.wait4(pid, 0)
wall = time.monotonic() - start
print(json.dumps({"cpu": used.ru_utime + used.ru_stime, "wall": wall, "peak": used.ru_maxrss * 1024, "status": os.waitstatus_to_exitcode(status)}), flush=True)
