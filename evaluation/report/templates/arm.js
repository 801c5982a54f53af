// Forward kinematics: poses are the upper three rows of a homogeneous matrix, row by row.
(() => {
  const product = (a, b) => {
    const c = new Float64Array(12);
    for (let i = 0; i < 3; i += 1) {
      for (let j = 0; j < 4; j += 1) {
        c[4 * i + j] = a[4 * i] * b[j] + a[4 * i + 1] * b[4 + j] + a[4 * i + 2] * b[8 + j] + (j === 3 ? a[4 * i + 3] : 0);
      }
    }
    return c;
  };
  const motion = (kind, [x, y, z], position) => {
    if (kind === "prismatic") return [1, 0, 0, x * position, 0, 1, 0, y * position, 0, 0, 1, z * position];
    const c = Math.cos(position), s = Math.sin(position), d = 1 - c;
    return [
      d * x * x + c, d * x * y - s * z, d * x * z + s * y, 0,
      d * x * y + s * z, d * y * y + c, d * y * z - s * x, 0,
      d * x * z - s * y, d * y * z + s * x, d * z * z + c, 0,
    ];
  };
  const point = (pose, x, y, z) => [0, 4, 8].map((row) => pose[row] * x + pose[row + 1] * y + pose[row + 2] * z + pose[row + 3]);

  // Returns the pose of every frame of a skeleton at joint positions q, base first.
  torquebench.poses = (skeleton, q) => {
    const found = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]];
    for (const [parent, rest, kind, axis, joint] of skeleton.frames) {
      const placed = product(found[parent], rest);
      found.push(joint < 0 ? placed : product(placed, motion(kind, axis, q[joint])));
    }
    return found;
  };
  torquebench.toolPoint = (skeleton, q) => point(torquebench.poses(skeleton, q)[skeleton.tool], 0, 0, 0);
  // Returns the capsules of a skeleton at joint positions q: start, end, radius.
  torquebench.capsules = (skeleton, q) => {
    const poses = torquebench.poses(skeleton, q);
    return skeleton.capsules.map(([frame, ax, ay, az, bx, by, bz, radius]) => ({
      start: point(poses[frame], ax, ay, az), end: point(poses[frame], bx, by, bz), radius,
    }));
  };
})();
