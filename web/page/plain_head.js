// What the sample head is compared with first.

/** The number of the plain head among the starting points. */
export const PLAIN_HEAD = 2;

/** What was matched beforehand for a request: the sample head with the plain one. Nothing for any other. */
export async function matchedBefore(shape, template, request) {
  if (shape !== "sample:head" || template !== "sample:template") return undefined;
  // Without a connection it may be missing, and one may break; the worker matches then.
  const found = fetch("bodies/head.match").then((answer) => (answer.ok ? answer.text() : undefined));
  const text = await found.catch(() => undefined);
  if (!text) return undefined;
  const end = text.indexOf("\n");
  return text.slice(0, end) === request ? text.slice(end + 1) : undefined;
}
