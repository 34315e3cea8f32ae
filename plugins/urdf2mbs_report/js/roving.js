// Groups of controls that are one stop of Tab each; arrow keys move within a group.

const STEPS = {ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1};

// Make the elements of a container that fit a selector one group.  onCurrent is called with the
// element that Tab stops at, whenever that changes.  Returns the function that looks for the
// elements again, after some were added or hidden.
export function makeRoving(container, selector, onCurrent = () => {}) {
  const isVisible = (element) => element.getClientRects().length > 0;
  const listElements = () => [...container.querySelectorAll(selector)];
  let current = null;
  const setCurrent = (element) => {
    if (current) current.tabIndex = -1;
    current = element;
    current.tabIndex = 0;
    onCurrent(current);
  };
  const refresh = () => {
    const elements = listElements();
    for (const element of elements) if (element !== current) element.tabIndex = -1;
    const isLost = !current || !elements.includes(current) || !isVisible(current);
    if (isLost && elements.length) setCurrent(elements.find(isVisible) || elements[0]);
  };
  container.addEventListener("focusin", (event) => {
    const element = event.target.closest(selector);
    if (element && element !== current) setCurrent(element);
  });
  container.addEventListener("keydown", (event) => {
    if (event.target !== current) return;
    const elements = listElements().filter(isVisible);
    const next = {Home: 0, End: elements.length - 1}[event.key]
      ?? elements.indexOf(current) + (STEPS[event.key] ?? NaN);
    if (!elements[next]) return;
    event.preventDefault();
    event.stopPropagation();
    elements[next].focus();
  });
  refresh();
  return refresh;
}
