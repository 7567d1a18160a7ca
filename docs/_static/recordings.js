// Puts a link beside each recording of a page that opens it in rerun's web viewer. The viewer reads the
// file from where the site is (`data-site`, by default where this page is), which has to allow it (CORS).
const { viewer, site } = document.currentScript.dataset;

document.addEventListener("DOMContentLoaded", () => {
  const root = new URL(document.documentElement.dataset.content_root, location.href).href;
  for (const recording of document.querySelectorAll('a[href$=".rrd"]')) {
    const address = site ? recording.href.replace(root, site) : recording.href;
    const link = document.createElement("a");
    link.href = `${viewer}?url=${encodeURIComponent(address)}`;
    link.textContent = "open it in the browser";
    recording.after(" (", link, ")");
  }
});
