"""Bootstrap confidence intervals (docs/metrics.md#confidence-intervals). Draws come from the library's Rng, so that intervals equal those of earlier tables."""
import functools

import numpy as np

ROUNDS, MOST_DRAWN = 1000, 1 << 21
MASK = (1 << 64) - 1
GOLDEN = 0x9E3779B97F4A7C15
LOW = np.uint64(0xFFFFFFFF)
UNKNOWN = {"mean": None, "low": None, "high": None}


def _finalise(x):
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9 & MASK
    x = (x ^ (x >> 27)) * 0x94D049BB133111EB & MASK
    return x ^ (x >> 31)


def fork(key, name, number=0):
    """Returns the key of Rng(key).Fork(name, number) (diffsac/core/random.h)."""
    hashed = 0xCBF29CE484222325
    for byte in name.encode():
        hashed = (hashed ^ byte) * 0x100000001B3 & MASK
    named = _finalise((_finalise(key + GOLDEN & MASK) ^ hashed) + GOLDEN & MASK)
    return _finalise(named + (number + 1) * GOLDEN & MASK)


def random_numbers(key, first, count):
    """Returns the results of calls `first`, `first` + 1, ... of Rng(key).NextU64(): Philox4x32-10, two numbers per block."""
    blocks = np.arange(first // 2, (first + count + 1) // 2, dtype=np.uint64)
    words = [blocks & LOW, blocks >> np.uint64(32), np.zeros_like(blocks), np.zeros_like(blocks)]
    keys = [key & 0xFFFFFFFF, key >> 32]
    for _ in range(10):
        one, two = words[0] * np.uint64(0xD2511F53), words[2] * np.uint64(0xCD9E8D57)
        words = [two >> np.uint64(32) ^ words[1] ^ np.uint64(keys[0]), two & LOW, one >> np.uint64(32) ^ words[3] ^ np.uint64(keys[1]), one & LOW]
        keys = [keys[0] + 0x9E3779B9 & 0xFFFFFFFF, keys[1] + 0xBB67AE85 & 0xFFFFFFFF]
    numbers = np.stack([words[0] | words[1] << np.uint64(32), words[2] | words[3] << np.uint64(32)], axis=1).ravel()
    return numbers[first % 2:first % 2 + count]


@functools.lru_cache(maxsize=8)
def _drawn(key, sizes, first, rounds):
    """Returns indices of drawn problems: rows are draws, columns are rounds. Follows Rng::Below without its rejection step (probability below 1e-15)."""
    size = np.repeat(np.array(sizes, np.uint64), sizes)
    numbers = random_numbers(key, first * len(size), rounds * len(size)).reshape(rounds, -1)
    below = (numbers >> np.uint64(32)) * size + ((numbers & LOW) * size >> np.uint64(32)) >> np.uint64(32)
    return np.ascontiguousarray((below + np.repeat(np.cumsum((0, *sizes[:-1])), sizes).astype(np.uint64)).T.astype(np.intp))


def _mean(values, ends, sizes):
    """Mean over scenes of each column. Rows are added in order, which keeps the last bit equal to the C++ program's."""
    return sum(values[end - size:end].sum(axis=0) / size for end, size in zip(ends, sizes)) / len(sizes)


def _quantile(ordered, share):
    at = share * (len(ordered) - 1)
    below = int(at)
    return ordered[below] + (at - below) * (ordered[min(below + 1, len(ordered) - 1)] - ordered[below])


def interval(values, sizes, seed):
    """Unweighted mean over scenes and its 95 % percentile interval. Problems are resampled within their scene; equal seeds and sizes give equal
    samples. `values` holds the scenes one after the other, `sizes` their lengths."""
    values, sizes = np.asarray(values, float), tuple(int(size) for size in sizes)
    if not sizes:
        return dict(UNKNOWN)
    key, ends = fork(seed, "bootstrap"), np.cumsum(sizes)
    step = max(1, min(ROUNDS, MOST_DRAWN // len(values)))
    means = np.sort(np.concatenate([_mean(values.take(_drawn(key, sizes, first, min(step, ROUNDS - first)), mode="clip"), ends, sizes)
                                    for first in range(0, ROUNDS, step)]))
    mean = sum(np.cumsum(values[end - size:end])[-1] / size for end, size in zip(ends, sizes)) / len(sizes)
    return {"mean": float(mean), "low": float(_quantile(means, (1 - 0.95) / 2)), "high": float(_quantile(means, (1 + 0.95) / 2))}
