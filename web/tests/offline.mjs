// The page without a connection.
import { serve } from "../browser.mjs";
import { acts } from "./caricature.mjs";
import { browser, folder, step, until } from "./driver.mjs";

export async function offline() {
  const server = await serve(folder);
  const context = await browser.newContext({ viewport: { width: 1000, height: 700 } });
  const page = await context.newPage();
  await page.goto(server.address);
  await until(page, () => window.chladni?.frames > 3 && window.chladni.sound.duration > 0);
  await until(page, async () => {
    const kept = await (await caches.open("chladni")).keys();
    return ["chladni_web_bg.wasm", "plate.body", "main.js", "worker.js"].every((name) => kept.some(({ url }) => url.endsWith(name)));
  });
  server.stop();
  await context.setOffline(true);
  await page.reload();
  await until(page, () => window.chladni?.frames > 3);
  await page.click("#exaggerate");
  await acts(page);
  step("it opens again without a connection");
  await context.close();
}
