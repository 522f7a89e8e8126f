//! Names of controls for programs: they stay where labels are reworded or translated.

/// What can be given one.
pub trait AuthorId {
    /// Makes it known as `id`, which tests and assistive programs find it by. Nobody is shown it.
    fn author_id(self, id: impl Into<String>) -> Self;
}

impl AuthorId for egui::Response {
    fn author_id(self, id: impl Into<String>) -> Self {
        self.ctx.accesskit_node_builder(self.id, |node| node.set_author_id(id));
        self
    }
}
