// Gestures as on maps: the wheel and one finger scroll the page; Ctrl and the wheel, or two fingers,
// move what is drawn.

// Call onWheel only for a wheel with Ctrl, as a pinch on a touchpad also says.
export function onZoomingWheel(element, onWheel) {
  element.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    onWheel(event);
  }, {passive: false});
}

// Call onMove for each movement of two fingers with where their middle was and is, and by which
// factor they have moved apart: {from, to, factor}, in px of the window.
export function onTwoFingers(element, onMove) {
  const measure = ([a, b]) => ({
    middle: [(a.clientX + b.clientX) / 2, (a.clientY + b.clientY) / 2],
    distance: Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) || 1,
  });
  let last = null;
  const begin = (event) => {
    last = event.touches.length === 2 ? measure(event.touches) : null;
    if (last) event.preventDefault();
  };
  element.addEventListener("touchstart", begin, {passive: false});
  element.addEventListener("touchend", begin, {passive: false});
  element.addEventListener("touchmove", (event) => {
    if (event.touches.length !== 2 || !last) return;
    event.preventDefault();
    const present = measure(event.touches);
    onMove({from: last.middle, to: present.middle, factor: present.distance / last.distance});
    last = present;
  }, {passive: false});
}
