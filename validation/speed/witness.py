"""One render by Mitsuba 3 in a process of its own: what it uses is what the operating system says of the process.

    witness.py VARIANT SCENE SPP SEED OUTPUT.npy [NAME=VALUE …]     X, Y, Z of the picture in OUTPUT.npy, and in lines of JSON what each step used
"""

import json
import os
import resource
import sys
import time


def used():
    """Seconds: of the processor for this process, and by the clock."""
    own = resource.getrusage(resource.RUSAGE_SELF)
    return own.ru_utime + own.ru_stime, time.monotonic()


def main():
    variant, scene, spp, seed, output, *defines = sys.argv[1:]
    steps = {"start": used()}
    import mitsuba
    import numpy as np

    mitsuba.set_variant(variant)
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    steps["program"] = used()
    loaded = mitsuba.load_file(scene, **dict(define.split("=", 1) for define in defines))
    steps["scene"] = used()
    # Turning the picture into an array waits for the threads that make it.
    picture = np.array(mitsuba.render(loaded, spp=int(spp), seed=int(seed)))
    steps["render"] = used()
    np.save(output, picture)
    names = list(steps)
    told = {name: [b - a for a, b in zip(steps[before], steps[name])] for before, name in zip(names, names[1:])}
    print(json.dumps(told | {"samples": loaded.sensors()[0].sampler().sample_count()}), flush=True)
    # Nothing more is wanted; taking a scene of millions of triangles apart would count as use.
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
