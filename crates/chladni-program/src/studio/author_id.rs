//! Names of controls for programs, which stay the same when labels are reworded or translated.

/// An element that can be given an id.
pub trait AuthorId {
    /// Gives it the name `id`, by which tests and assistive programs find it. It is never shown.
    fn author_id(self, id: impl Into<String>) -> Self;
}

impl AuthorId for egui::Response {
    fn author_id(self, id: impl Into<String>) -> Self {
        self.ctx.accesskit_node_builder(self.id, |node| node.set_author_id(id));
        self
    }
}
