// Arrows of forces, each at a point of a body, in the axes of the base.

import {byId, robotSize, vector} from "./basics.js";
import {MARK_COLORS} from "./marks.js";
import {scene} from "./scene.js";

// Make an arrow for each force; arePushes says which are pushes of the user.  Returns the function
// that draws an arrow: its number, the pose of its body, its point in the body (m), the force (N),
// and the force (N) that is drawn as half of the robot.
export function makeForceArrows(arePushes) {
  const arrows = arePushes.map((isPush) => {
    const color = isPush ? MARK_COLORS.stops : MARK_COLORS.forces;
    const arrow = new THREE.ArrowHelper(vector(0, 0, 1), vector(), 1, color);
    arrow.visible = false;
    for (const part of isPush ? [arrow.line, arrow.cone] : []) {
      part.material.depthTest = false;  // it begins inside the body
      part.renderOrder = 9;
    }
    scene.add(arrow);
    return arrow;
  });
  return (number, bodyPose, point, force, largestForce) => {
    const arrow = arrows[number], length = force.length() / largestForce * robotSize / 2;
    arrow.visible = length > 0.002 * robotSize && byId("show-forces").checked;
    if (!arrow.visible) return;
    arrow.position.copy(point).applyMatrix4(bodyPose);
    arrow.setDirection(force.clone().normalize());
    arrow.setLength(length, Math.min(robotSize / 20, length / 2), robotSize / 40);
  };
}
