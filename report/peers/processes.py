"""Runs in a process of their own."""

import multiprocessing


def in_a_process(call, limit):
    """What a call returns in a process of its own, or None and why not: a peer may stop it, or not end."""
    mine, its = multiprocessing.Pipe(duplex=False)

    def run():
        its.send(call())

    child = multiprocessing.get_context("fork").Process(target=run)
    child.start()
    its.close()
    try:
        answer = (mine.recv(), "") if mine.poll(limit) else (None, "late")
    except EOFError:
        child.join()
        answer = None, f"the program ended by signal {-child.exitcode}"
    child.kill()
    child.join()
    return answer
