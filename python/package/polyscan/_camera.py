"""Cameras: how points in object space come to pixels, and what their depth is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from ._lens import Lens


class View(NamedTuple):
    """What a camera is for pictures of one size."""

    #: (4, 4) f64: from object space to clip space.
    clip_from_object: np.ndarray
    #: (4,) f64: the depth of a point (x, y, z, 1) is the product with it.
    depth_row: np.ndarray
    #: Whether that is the w of clip space times a number, and which.
    depth_per_w: float | None
    #: Whether clip space is -w <= z <= w, as in OpenGL; else 0 <= z <= w.
    is_opengl: bool
    #: Whether greater z/w are nearer.
    is_reversed: bool
    #: What bends straight lines, if anything does.
    bend: Bend | None = None


class Bend(NamedTuple):
    """A lens, and the pinhole behind it."""

    lens: Lens
    #: (4, 4) from object space to the camera's.
    pose: np.ndarray
    #: (4, 4) from the camera's space to clip space.
    projection: np.ndarray
    #: (2, 3) from x/z and y/z to pixels, from the picture's outer edges.
    inner: np.ndarray
    near: float


class Seeing(Protocol):
    """What makes a view for pictures of any size."""

    def view(self, width: int, height: int) -> View: ...


@dataclass(frozen=True, eq=False)
class Pinhole:
    """By focal lengths in pixels."""

    K: np.ndarray
    center: float
    pose: np.ndarray
    z_row: list[float]
    near: float
    lens: Lens | None

    def view(self, width: int, height: int) -> View:
        scale_x, scale_y = 2 / width, 2 / height
        # To pixels from their outer edges, then to -1 to 1 with y up.
        x, y = scale_x * self.K[0], -scale_y * self.K[1]
        x[2] += scale_x * (0.5 - self.center) - 1
        y[2] += 1 - scale_y * (0.5 - self.center)
        projection = np.array([[*x, 0], [*y, 0], self.z_row, [0, 0, 1, 0]])
        bend = None
        if self.lens is not None:
            inner = self.K[:2].copy()
            inner[:, 2] += 0.5 - self.center
            bend = Bend(self.lens, self.pose, projection, inner, self.near)
        return View(projection @ self.pose, self.pose[2], 1.0, False, True, bend)


@dataclass(frozen=True, eq=False)
class Angle:
    """By the vertical angle of view."""

    focal: float
    pose: np.ndarray
    z_row: list[float]

    def view(self, width: int, height: int) -> View:
        projection = np.diag([self.focal * height / width, -self.focal, 0, 0])
        projection[2], projection[3, 2] = self.z_row, 1
        return View(projection @ self.pose, self.pose[2], 1.0, False, True)


@dataclass(frozen=True, eq=False)
class Fixed:
    """The same for pictures of all sizes."""

    fixed: View

    def view(self, width: int, height: int) -> View:
        return self.fixed


@dataclass(frozen=True, eq=False)
class Framed:
    """From a direction, as far from a sphere as it must be."""

    centre: np.ndarray
    radius: float
    towards: np.ndarray
    up: np.ndarray
    angle: float

    def view(self, width: int, height: int) -> View:
        # The sphere fills the shorter side.
        half = np.radians(self.angle) / 2
        narrow = np.arctan(np.tan(half) * min(1.0, width / height))
        distance = 1.01 * self.radius / np.sin(narrow)
        pose = look_at(self.centre + self.towards * distance, self.centre, self.up)
        near = max(distance - 1.1 * self.radius, 1e-4 * distance)
        return Camera.perspective(self.angle, pose, near=near).view(width, height)


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera. Made by `opencv`, `perspective`, `orthographic`, `projection` or `around`.

    A pose is a matrix from object space to the camera's space, (4, 4) or (3, 4), as OpenCV's extrinsics are. In the
    camera's space x is to the right, y DOWN and z ahead. `look_at` makes poses; `opengl_pose` converts those of
    cameras that have y up and look along -z.

    Depth is in the unit of object space: the distance ahead of the camera, along the direction of view, not along
    the ray.
    """

    _seeing: Seeing

    @classmethod
    def opencv(
        cls,
        K: npt.ArrayLike,
        pose: npt.ArrayLike | None = None,
        *,
        distortion: npt.ArrayLike | None = None,
        fisheye: bool = False,
        lens_error: float = 0.1,
        near: float = 1e-3,
        far: float = np.inf,
        pixel_center: float = 0.0,
    ) -> Camera:
        """OpenCV's camera: a point at (x, y, z) in the camera's space is seen at
        (fx x / z + cx, fy y / z + cy).

        The half-pixel rule: OpenCV counts pixels from their centres, so that the centre of the top left pixel is at
        (0, 0), and the middle of a picture 640 pixels wide at cx = 319.5. With `pixel_center=0.5`, as in COLMAP, that
        centre is at (0.5, 0.5), and the middle at 320.

        K: (3, 3): fx, skew, cx; 0, fy, cy; 0, 0, 1, in pixels.
        pose: (4, 4) or (3, 4), from object space to the camera's; the identity if left out.
        distortion: OpenCV's coefficients (k1, k2, p1, p2[, k3[, k4, k5, k6]]) of Brown and Conrady's lens, or with
            `fisheye` (k1, k2, k3, k4) of Kannala and Brandt's. K is that of the distorted picture. Where the lens shows
            nothing, because farther out would be farther in, there is nothing; nor is there beyond 89 degrees.
        lens_error: how many pixels what is seen may be from where the lens shows it: triangles are cut until it is less.
        near, far: distances ahead, in the unit of object space, between which things are seen. The precision of depth
            does not depend on them.
        """
        K = arguments.finite("K", K, (3, 3))
        if K[0, 0] <= 0 or K[1, 1] <= 0 or K[1, 0] != 0 or list(K[2]) != [0, 0, 1]:
            raise ValueError(f"K must be [[fx, skew, cx], [0, fy, cy], [0, 0, 1]] with focal lengths above 0, not {K.tolist()}")
        center = arguments.number("pixel_center", pixel_center)
        if distortion is None and fisheye:
            raise ValueError("distortion is needed for a fisheye: four zeros are an equidistant one")
        lens = None if distortion is None else Lens.of(distortion, bool(fisheye), lens_error)
        return cls(Pinhole(K, center, _pose(pose), _z_row(near, far), float(near), lens))

    @classmethod
    def perspective(
        cls,
        field_of_view: float,
        pose: npt.ArrayLike | None = None,
        *,
        near: float = 1e-3,
        far: float = np.inf,
    ) -> Camera:
        """A camera with square pixels that looks through the middle of the picture.

        field_of_view: the angle from the picture's lower to its upper side, in degrees.
        """
        angle = arguments.number("field_of_view", field_of_view, 1e-3, 179.0)
        return cls(Angle(1 / float(np.tan(np.radians(angle) / 2)), _pose(pose), _z_row(near, far)))

    @classmethod
    def orthographic(cls, width: float, height: float, pose: npt.ArrayLike | None = None, *, near: float, far: float) -> Camera:
        """A parallel projection, as of plans, maps and height fields.

        width, height: what the picture shows, in the unit of object space; the camera is in the middle.
        near, far: distances ahead between which things are seen; they may be below 0.
        """
        width = arguments.number("width", width, 1e-300)
        height = arguments.number("height", height, 1e-300)
        near, far = arguments.number("near", near), arguments.number("far", far)
        if near >= far:
            raise ValueError(f"near must be below far, but is {near}, and far is {far}")
        object_to_camera = _pose(pose)
        projection = np.diag([2 / width, -2 / height, 1 / (far - near), 1])
        projection[2, 3] = -near / (far - near)
        view = View(projection @ object_to_camera, object_to_camera[2], None, False, False)
        return cls(Fixed(view))

    @classmethod
    def projection(
        cls,
        matrix: npt.ArrayLike,
        *,
        depth_range: str = "zero_to_one",
        reversed_depth: bool = False,
    ) -> Camera:
        """A camera by its matrix from object space to clip space, in which x is to the right and y UP.

        Depth is the distance ahead for a perspective, and the distance from the near plane for a parallel
        projection, in the unit of object space.

        matrix: (4, 4), for column vectors: projection times view times model.
        depth_range: "zero_to_one" for 0 <= z <= w (Direct3D, Vulkan, Metal), "minus_one_to_one" for -w <= z <= w
            (OpenGL).
        reversed_depth: whether z/w is greater for what is nearer.
        """
        rows = arguments.finite("matrix", matrix, (4, 4))
        is_opengl = _is_opengl(depth_range)
        length = np.linalg.norm(rows[3, :3])
        if length > 0:
            view = View(rows, rows[3] / length, float(1 / length), is_opengl, bool(reversed_depth))
            return cls(Fixed(view))
        # All look along the direction in which x and y do not change.
        ahead = np.cross(rows[0, :3], rows[1, :3])
        along = abs(rows[2, :3] @ ahead) / np.linalg.norm(ahead) if ahead.any() else 0.0
        if along == 0 or rows[3, 3] <= 0:
            raise ValueError("matrix must have an inverse and a positive last number, or nothing is seen")
        near = rows[3] - rows[2] if reversed_depth else rows[2] + is_opengl * rows[3]
        view = View(rows, near / along, None, is_opengl, bool(reversed_depth))
        return cls(Fixed(view))

    @classmethod
    def clip_space(cls, *, depth_range: str = "zero_to_one", reversed_depth: bool = False) -> Camera:
        """The camera of vertices (n, 4) that are in clip space already. Their depth is their w."""
        row = np.array([0.0, 0.0, 0.0, 1.0])
        view = View(np.eye(4), row, 1.0, _is_opengl(depth_range), bool(reversed_depth))
        return cls(Fixed(view))

    @classmethod
    def around(
        cls,
        vertices: npt.ArrayLike,
        *,
        yaw: float = 30.0,
        pitch: float = 20.0,
        up: npt.ArrayLike = (0.0, 1.0, 0.0),
        field_of_view: float = 34.0,
    ) -> Camera:
        """A camera that sees all of a model, in pictures of any shape.

        vertices: (n, 3).
        yaw, pitch: how far the camera has gone around the model to the right, and above it, in degrees. At zero it
            looks along -z if y is up, and along y if z is up.
        """
        points = arguments.vertices(vertices).reshape(-1, np.shape(vertices)[-1])[:, :3].astype(np.float64)
        if len(points) == 0 or not np.isfinite(points).all():
            raise ValueError("vertices must be at least one, and finite")
        low, high = points.min(axis=0), points.max(axis=0)
        centre = (low + high) / 2
        radius = float(np.sqrt(((points - centre) ** 2).sum(axis=1).max())) or 1.0
        angle = arguments.number("field_of_view", field_of_view, 1e-3, 179.0)
        yaw, pitch = np.radians(arguments.number("yaw", yaw)), np.radians(arguments.number("pitch", pitch))
        towards = np.array([np.sin(yaw) * np.cos(pitch), np.sin(pitch), np.cos(yaw) * np.cos(pitch)])
        upwards = np.array([-np.sin(yaw) * np.sin(pitch), np.cos(pitch), -np.cos(yaw) * np.sin(pitch)])
        turn = _upright(arguments.finite("up", up, (3,)))
        return cls(Framed(centre, radius, turn @ towards, turn @ upwards, angle))

    def view(self, width: int, height: int) -> View:
        """What the camera is for pictures of a size: for the package's own use."""
        return self._seeing.view(width, height)

    def matrix(self, width: int, height: int) -> np.ndarray:
        """The matrix (4, 4) from object space to clip space for pictures of a size, without distortion. z is from 0 to
        w, or as the camera was told; of `opencv`, `perspective` and `around` it is w at the near plane, 0 far away."""
        return self.view(*arguments.size((width, height))).clip_from_object.copy()


def look_at(eye: npt.ArrayLike, target: npt.ArrayLike, up: npt.ArrayLike = (0.0, 1.0, 0.0)) -> np.ndarray:
    """The pose (4, 4) of a camera at `eye` that looks at `target`, with `up` upwards in the picture."""
    eye, target = arguments.finite("eye", eye, (3,)), arguments.finite("target", target, (3,))
    ahead = target - eye
    down = -arguments.finite("up", up, (3,))
    right = np.cross(down, ahead)
    if not np.linalg.norm(right) > 1e-12 * np.linalg.norm(ahead) * np.linalg.norm(down):
        raise ValueError(f"up must not point along the direction of view, {ahead.tolist()}, and neither may be zero")
    right, ahead = right / np.linalg.norm(right), ahead / np.linalg.norm(ahead)
    pose = np.eye(4)
    pose[:3, :3] = right, np.cross(ahead, right), ahead
    pose[:3, 3] = -pose[:3, :3] @ eye
    return pose


def opengl_pose(camera_to_world: npt.ArrayLike) -> np.ndarray:
    """The pose (4, 4) for a camera's matrix to the world as OpenGL, glTF, Blender and pyrender have it: x to the right,
    y up, looking along -z."""
    matrix = arguments.finite("camera_to_world", camera_to_world, (4, 4))
    if abs(np.linalg.det(matrix)) < 1e-300:
        raise ValueError("camera_to_world must have an inverse")
    return np.diag([1.0, -1.0, -1.0, 1.0]) @ np.linalg.inv(matrix)


def _pose(pose: npt.ArrayLike | None) -> np.ndarray:
    if pose is None:
        return np.eye(4)
    made = arguments.array("pose", pose).astype(np.float64)
    if made.shape == (3, 4):
        made = np.vstack([made, [0.0, 0.0, 0.0, 1.0]])
    made = arguments.finite("pose", made, (4, 4))
    if list(made[3]) != [0, 0, 0, 1]:
        raise ValueError(f"pose must have the last row [0, 0, 0, 1], not {made[3].tolist()}")
    return made


def _z_row(near: float, far: float) -> list[float]:
    """z of clip space: w at the near plane, 0 at the far one, so that depths are as fine as f32 can be everywhere."""
    near = arguments.number("near", near, 1e-30)
    far = arguments.any_number("far", far)
    if far == np.inf:
        return [0.0, 0.0, 0.0, near]
    far = arguments.number("far", far)
    if near >= far:
        raise ValueError(f"near must be below far, but is {near}, and far is {far}")
    return [0.0, 0.0, -near / (far - near), near * far / (far - near)]


def _is_opengl(depth_range: str) -> bool:
    return arguments.one_of("depth_range", depth_range, ("zero_to_one", "minus_one_to_one")) == "minus_one_to_one"


def _upright(up: np.ndarray) -> np.ndarray:
    """The shortest turn that takes y to a direction."""
    if not np.linalg.norm(up) > 0:
        raise ValueError("up must not be zero")
    up = up / np.linalg.norm(up)
    if up[1] < -0.999999:
        return np.diag([1.0, -1.0, -1.0])
    axis = np.array([up[2], 0.0, -up[0]])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + cross + cross @ cross / (1 + up[1])
