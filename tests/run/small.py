"""Scenes that take a run of the paper's pipelines no time, as overrides."""

KNIGHTS = (
    "scene.resolution=[72,56]",
    "scene.mesh.parameters.knights=3",
    "scene.mesh.parameters.radius=1.5",
    "scene.lights.0.position=[3, 1, 6]",
    "scene.camera.eye=[0, -7, 2]",
    "workload.range=20",
)
