// Cell of a notebook: shows the page in a frame of its own, and relays messages.
export default {
  render({ model, el }) {
    const frame = document.createElement("iframe");
    frame.title = "hertzchain";
    // Without allow-same-origin, the page cannot reach the notebook.
    frame.setAttribute("sandbox", "allow-scripts allow-downloads allow-modals");
    Object.assign(frame.style, { width: "100%", height: `${model.get("height")}px`, border: "0" });
    frame.srcdoc = model.get("page");
    const toKernel = (event) => {
      if (event.source === frame.contentWindow) model.send(event.data);
    };
    const toPage = (message, buffers) => {
      const copies = (buffers ?? []).map((each) => (each.buffer ? each.buffer.slice(each.byteOffset, each.byteOffset + each.byteLength) : each));
      frame.contentWindow?.postMessage({ content: message.content, buffers: copies }, "*", copies);
    };
    addEventListener("message", toKernel);
    model.on("msg:custom", toPage);
    el.append(frame);
    return () => {
      removeEventListener("message", toKernel);
      model.off("msg:custom", toPage);
    };
  },
};
