// SPDX-License-Identifier: Apache-2.0
// The time line: which step is shown, and what moves it.

const SPEEDS = [0.5, 1, 2, 5, 10]; // steps a second

// `show` is called with the place whenever it changes, and `moved` where the reader has changed it. `keys` has more
// keys of the page.
function timeLineOf(names, show, moved, keys) {
  const slider = byId("slider"), play = byId("play"), speed = byId("speed");
  let count = 1, at = 0, timer = null, isPlaying = false;
  speed.replaceChildren(...SPEEDS.map((one) => html("option", { value: one, selected: one === 1 }, `${one} a second`)));

  function go(place) {
    at = Math.min(count - 1, Math.max(0, place));
    slider.value = at;
    slider.setAttribute("aria-valuetext", names(at));
    byId("place").textContent = names(at);
    byId("back").disabled = byId("first").disabled = at === 0;
    byId("forward").disabled = byId("last").disabled = at === count - 1;
    show(at);
  }

  // There are so many places now.
  function grow(places) {
    count = places;
    slider.max = count - 1;
    go(at);
  }

  function setPlaying(wanted) {
    clearTimeout(timer);
    isPlaying = wanted && count > 1;
    play.textContent = isPlaying ? "❚❚" : "▶";
    play.setAttribute("aria-label", isPlaying ? "Pause" : "Play");
    play.setAttribute("aria-pressed", String(isPlaying));
    if (!isPlaying) return;
    if (at === count - 1) go(0);
    schedule();
  }

  function schedule() {
    timer = setTimeout(() => {
      go(at + 1);
      if (at === count - 1) setPlaying(false);
      else schedule();
    }, 1000 / Number(speed.value));
  }

  function faster(by) {
    const now = SPEEDS.indexOf(Number(speed.value));
    speed.value = String(SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, now + by))]);
  }

  function byHand(place) {
    setPlaying(false);
    moved();
    go(place);
  }

  function pressPlay() {
    moved();
    setPlaying(!isPlaying);
  }

  play.addEventListener("click", pressPlay);
  slider.addEventListener("input", () => byHand(Number(slider.value)));
  byId("first").addEventListener("click", () => byHand(0));
  byId("back").addEventListener("click", () => byHand(at - 1));
  byId("forward").addEventListener("click", () => byHand(at + 1));
  byId("last").addEventListener("click", () => byHand(count - 1));

  const pressed = {
    " ": pressPlay, ArrowLeft: () => byHand(at - 1), ArrowRight: () => byHand(at + 1),
    Home: () => byHand(0), End: () => byHand(count - 1), "+": () => faster(1), "-": () => faster(-1), ...keys,
  };
  document.addEventListener("keydown", (event) => {
    const target = event.target;
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (target.closest("[role=tree], select, input:not([type=range]):not([type=checkbox])")) return;
    if (target.closest("button, input, summary") && event.key === " ") return; // it presses that
    if (target.id === "slider" && /^(Arrow|Home|End)/.test(event.key)) return; // it moves by itself
    const action = pressed[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
  return { go: byHand, show: go, grow };
}
