# SPDX-License-Identifier: Apache-2.0
"""The loop of a Gymnasium user: a random policy, a planner, and a thousand worlds at once.

Needs the extra ``gym``: pip install 'hypgen[gym]'.
"""

from pathlib import Path

import numpy as np

import hypgen

model = hypgen.load(Path(__file__).parents[1] / "rock_sample.pomdp")
solver = model.compile()

# A random policy asks the mask which actions are legal.
env = solver.env(steps=60)
env.action_space.seed(1)
observation, info = env.reset(seed=1)
earned, over = 0.0, False
while not over:
    action = env.action_space.sample(mask=info["action_mask"])
    observation, reward, terminated, truncated, info = env.step(action)
    earned += reward
    over = terminated or truncated
print(f"random policy: {earned:g}; an observation has {', '.join(env.names)}")

# A planner is told by name what the environment shows.
with solver.planner(mode="despot", trials=20, scenarios=50, seed=1, memory=64) as planner:
    env.reset(seed=1)
    planner.reset(env.visible)
    earned, over = 0.0, False
    while not over:
        decision = planner.plan()
        _, reward, terminated, truncated, _ = env.step(decision.action)
        if not terminated:
            planner.update(decision.action, env.seen)
        earned += reward
        over = terminated or truncated
print(f"planner: {earned:g}")
env.close()

# A thousand worlds side by side: arrays in, arrays out.
envs = solver.vector_env(1000, steps=60)
random = np.random.default_rng(1)
observations, info = envs.reset(seed=1)
total = 0.0
for _ in range(200):
    scores = random.random(info["action_mask"].shape) * info["action_mask"]
    observations, rewards, terminated, truncated, info = envs.step(scores.argmax(axis=1))
    total += rewards.sum()
print(f"a thousand random policies: {total / 1000:g} each in 200 steps")
envs.close()
