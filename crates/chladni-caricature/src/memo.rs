//! The last result of a computation, kept as long as its inputs stay the same.

use std::sync::Arc;

/// One remembered value and the inputs it came from.
#[derive(Clone, Debug)]
pub(crate) struct Memo<K, V>(Option<(K, V)>);

impl<K, V> Default for Memo<K, V> {
    fn default() -> Self {
        Self(None)
    }
}

impl<K: PartialEq, V: Clone> Memo<K, V> {
    /// The value for `inputs`: the remembered one, or a new one. An error is not remembered.
    pub(crate) fn get<E>(&mut self, inputs: K, compute: impl FnOnce() -> Result<V, E>) -> Result<V, E> {
        if let Some((known, value)) = &self.0
            && *known == inputs
        {
            return Ok(value.clone());
        }
        let value = compute()?;
        self.0 = Some((inputs, value.clone()));
        Ok(value)
    }
}

/// A shared value that equals only itself, whatever it holds.
#[derive(Debug)]
pub(crate) struct Same<T: ?Sized>(pub Arc<T>);

impl<T: ?Sized> Clone for Same<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T: ?Sized> PartialEq for Same<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl<T: ?Sized> From<&Arc<T>> for Same<T> {
    fn from(value: &Arc<T>) -> Self {
        Self(value.clone())
    }
}
