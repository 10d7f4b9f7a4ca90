// SPDX-License-Identifier: Apache-2.0
// A page of a run that goes on: asks the server for what is new, and follows it until the reader looks elsewhere.

const LIVE_PAUSE = 400; // milliseconds between questions

// `grown` shows steps that have come; `latest` goes to the newest. Gives whether the newest is followed.
function liveOf(view, grown, latest) {
  const button = byId("live"), said = byId("live-said");
  let follows = true, isOver = false, next = null;

  function setFollows(wanted) {
    follows = wanted;
    button.setAttribute("aria-pressed", String(follows));
    if (follows && next !== null) location.reload();
    else if (follows) latest();
  }

  async function ask() {
    let news = null;
    try {
      const answer = await fetch(`news?episode=${view.episode}&steps=${view.steps.length}`);
      if (answer.ok) news = await answer.json();
    } catch { /* the server ends with the run */ }
    if (news) take(news);
    else isOver = true;
    if (!isOver) setTimeout(ask, LIVE_PAUSE);
    said.textContent = news && news.problem ? news.problem
      : isOver ? "The run is over." : next !== null ? `Episode ${next} is played: “Live” shows it.` : "";
  }

  function take(news) {
    isOver = news.over;
    if (news.steps) {
      const isNew = news.steps.length > 0 || (news.end && !view.end);
      view.steps.push(...news.steps);
      view.steps.forEach((step, at) => { step.earned = news.earned[at]; });
      Object.assign(view, { end: news.end, ended: news.ended, notes: news.notes });
      if (isNew) {
        grown();
        if (follows) latest();
      }
    } else if (news.episode !== null && !isOver) {
      next = news.episode;
      if (follows) location.reload();
    }
  }

  button.addEventListener("click", () => setFollows(!follows));
  setTimeout(ask, LIVE_PAUSE);
  return { leave: () => follows && setFollows(false) };
}
