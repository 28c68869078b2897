"""Memory, time and signals of a process that fits."""

import gc
import json
import os
import resource
import subprocess
import sys
import textwrap
import time

import aberfit


def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


def test_memory_stays_flat(small):
    # What the allocator keeps goes up and down by some 10 MB; a leak raises the lowest of many values.
    fits = int(os.environ.get("ABERFIT_FITS", "20"))
    held = []
    for _ in range(4 + fits):
        aberfit.fit(small, threads=2).focus
        gc.collect()
        held.append(resident())
    first, second = held[4 : 4 + fits // 2], held[4 + fits // 2 :]
    assert min(second) - min(first) < 5e6, held


def test_ctrl_c_ends_with_the_best_so_far(small, tmp_path):
    code = textwrap.dedent(
        """
        import json, os, signal, sys, threading, time
        import aberfit
        study = json.loads(sys.argv[1])
        told = []
        def press(line):
            if "iteration" in line or len(told) > 0:
                if not told:
                    told.append(time.monotonic())
                    os.kill(os.getpid(), signal.SIGINT)
        try:
            result = aberfit.fit(study, progress=press)
            print("result", result.interrupted, result["fit"]["stopped_by"], time.monotonic() - told[0])
        except KeyboardInterrupt:
            print("nothing", time.monotonic() - told[0])
    """
    )
    slow = small | {
        "terms": {"zernike": {"n_max": 60}},
        "target": {},
        "roughness": {"psd": {"model": "uniform", "rms": "30 nm", "f_min": "6 /m", "f_max": "90 /m"}},
    }
    done = subprocess.run([sys.executable, "-c", code, json.dumps(slow)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    words = done.stdout.split()
    assert words[0] in ("result", "nothing"), done.stdout
    assert float(words[-1]) < 5, done.stdout
    if words[0] == "result":
        assert words[1] == "True" and "Ctrl-C" in done.stdout


def test_the_process_may_end_while_a_fit_runs(small):
    code = textwrap.dedent(
        """
        import json, sys, threading, time
        import aberfit
        study = json.loads(sys.argv[1])
        threading.Thread(target=lambda: aberfit.fit(study), daemon=True).start()
        time.sleep(0.3)
    """
    )
    slow = small | {"terms": {"zernike": {"n_max": 60}}, "target": {}}
    done = subprocess.run([sys.executable, "-c", code, json.dumps(slow)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_forked_process_ends_while_its_parent_fits(small):
    code = textwrap.dedent(
        """
        import json, os, sys, threading, time
        import aberfit
        study = json.loads(sys.argv[1])
        fit = threading.Thread(target=lambda: aberfit.fit(study), daemon=True)
        fit.start()
        time.sleep(0.3)
        child = os.fork()
        if child == 0:
            sys.exit(3)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), fit.is_alive())
    """
    )
    slow = small | {"terms": {"zernike": {"n_max": 60}}, "target": {}}
    done = subprocess.run(
        [sys.executable, "-c", code, json.dumps(slow)], capture_output=True, text=True, timeout=60
    )
    assert done.stdout.split() == ["3", "True"], done.stderr


def test_ctrl_c_ends_a_loop_of_checks(small):
    code = textwrap.dedent(
        """
        import json, os, signal, sys, threading
        import aberfit
        study = json.loads(sys.argv[1])
        threading.Timer(0.4, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        try:
            for _ in range(10000):
                aberfit.check(study)
        except KeyboardInterrupt:
            print("ended")
    """
    )
    done = subprocess.run([sys.executable, "-c", code, json.dumps(small)], capture_output=True, text=True)
    assert done.stdout.strip() == "ended", done.stderr


def test_overhead_is_small(small, monkeypatch):
    # The whole function with the compiled command replaced by its answer, and with what a user reads of it.
    from aberfit import _aberfit

    answer = _aberfit.run(
        "check",
        _aberfit.StudyText(json.dumps(small), "study", [], _aberfit.StudyData()),
        _aberfit.Settings(),
        None,
    )
    monkeypatch.setattr(_aberfit, "run", lambda *arguments: answer)
    times = []
    for _ in range(20):
        begin = time.perf_counter()
        assert aberfit.check(small)["kind"] == "check"
        times.append(time.perf_counter() - begin)
    assert min(times) < 2e-3, times
