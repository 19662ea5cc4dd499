"""A training step of configs/line.yaml: diffsac_train, and the same network in PyTorch (pip install torch==2.11.0), eager and by torch.compile
(which needs g++), in turn, as Markdown: milliseconds by the clock and of processor time, the least of the rounds' means. PyTorch's step is forward,
losses, backward and Adam on random tensors, float32. That of diffsac_train, by the steps a second that it says and by its processor time beyond
that of ten steps, makes its data, clips gradients and averages weights besides."""

import os
import re
import resource
import subprocess
import tempfile
import time

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")  # as diffsac_train, for machines that others use
import torch  # noqa: E402
from torch import nn  # noqa: E402
from torch.nn import functional as F  # noqa: E402

WIDTH, HEADS, FEATURES, BATCH, COPIES, POINTS, PARAMETERS = 64, 4, 50, 64, 2, 100, 409562
PROGRAM, STEPS, ROUNDS = "build/release/bin/diffsac_train", 20, 3


class Block(nn.Module):  # lib/lab/torch/pooled_block.cpp
    def __init__(self):
        super().__init__()
        self.norm, self.attention = nn.LayerNorm(WIDTH), nn.Linear(WIDTH, HEADS)
        self.set, self.point = nn.Linear((2 + HEADS) * WIDTH, 2 * WIDTH), nn.Linear(WIDTH, 2 * WIDTH)
        self.output = nn.Linear(2 * WIDTH, WIDTH)

    def forward(self, x):
        u = self.norm(x)
        heads = torch.bmm(self.attention(u).softmax(1).transpose(1, 2), u)
        pooled = torch.cat([u.mean(1), u.amax(1), heads.flatten(1)], -1)
        return x + self.output(F.gelu(self.point(u) + self.set(pooled).unsqueeze(1), approximate="tanh"))


class Network(nn.Module):  # lib/lab/torch/denoiser_base.cpp
    def __init__(self):
        super().__init__()
        self.input, self.confidence = nn.Linear(FEATURES, WIDTH), nn.Linear(1, WIDTH)
        self.encoder, self.decoder = (nn.Sequential(*(Block() for _ in range(n))) for n in (4, 2))
        self.encoded, self.decoded = nn.LayerNorm(WIDTH), nn.LayerNorm(WIDTH)
        self.hidden, self.time = nn.Linear(WIDTH, WIDTH), nn.Linear(WIDTH, WIDTH)
        self.inlier, self.output = nn.Linear(WIDTH, 1), nn.Linear(WIDTH, 1)

    def forward(self, features, noised, t):
        points = self.encoded(self.encoder(self.input(features)))
        angles = t.unsqueeze(-1) * 10000.0 ** (-torch.arange(WIDTH // 2) / (WIDTH // 2))
        embedded = self.time(F.silu(self.hidden(torch.cat([angles.cos(), angles.sin()], -1))))
        h = self.confidence(noised.unsqueeze(-1)) + points.unsqueeze(1) + embedded.unsqueeze(2)
        return self.inlier(points).squeeze(-1), self.output(self.decoded(self.decoder(h.flatten(0, 1)))).view_as(noised)


def of_pytorch(threads, compiled):
    network = Network()
    assert sum(p.numel() for p in network.parameters()) == PARAMETERS
    adam, call = torch.optim.Adam(network.parameters(), 1e-3, fused=True), torch.compile(network) if compiled else network
    inputs = torch.randn(BATCH, POINTS, FEATURES), torch.randn(BATCH, COPIES, POINTS), torch.rand(BATCH, COPIES) * 99
    inliers, labels = torch.rand(BATCH, POINTS).round(), torch.rand(BATCH, COPIES, POINTS).round()

    def steps(count, loss=F.binary_cross_entropy_with_logits):
        wall, cpu = time.perf_counter(), time.process_time()
        for _ in range(count):
            adam.zero_grad()
            inlier, output = call(*inputs)
            (loss(output, labels) + loss(inlier, inliers)).backward()
            adam.step()
        return (time.perf_counter() - wall) / count, (time.process_time() - cpu) / count

    torch.set_num_threads(threads)
    steps(10)  # compiles
    return lambda: steps(STEPS)


def of_program(threads):
    spent = [sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])]
    for count in (10, 10 + 5 * STEPS):
        with tempfile.TemporaryDirectory() as folder:
            options = ["--threads", str(threads), "--output", folder + "/run", "--set", f"train.iterations={count}"]
            options += ["--device", "cpu", "--set", "train.validate_every=100000", "--set", "validation.problems=1"]
            said = subprocess.run([PROGRAM, "--config", "configs/line.yaml"] + options, check=True, capture_output=True).stderr
        spent.append(sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]))
    return 1 / float(re.findall(rb"training: 100% \S+ ([\d.]+)/s", said)[-1]), (spent[2] - 2 * spent[1] + spent[0]) / (5 * STEPS)


print(f"PyTorch {torch.__version__}\n\n| | threads | a step, ms | processor time, ms |\n|---|---|---|---|")
for threads in (1, 2):
    rows = {"PyTorch eager": of_pytorch(threads, False), "torch.compile": of_pytorch(threads, True), "diffsac_train": lambda: of_program(threads)}
    rounds = [{name: measure() for name, measure in rows.items()} for _ in range(ROUNDS)]
    for name in rows:
        print(f"| {name} | {threads} | " + " | ".join(f"{1e3 * min(r[name][i] for r in rounds):.0f}" for i in (0, 1)) + " |", flush=True)
