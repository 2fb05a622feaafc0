use std::io;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

/// Makes the items on a thread of its own, up to `most` before they are asked for. It ends when the receiver
/// is dropped.
pub fn ahead<T: Send + 'static>(
    most: usize,
    items: impl Iterator<Item = T> + Send + 'static,
) -> io::Result<Receiver<T>> {
    let (sender, receiver) = sync_channel(most);
    thread::Builder::new().name("tables".into()).spawn(move || {
        for item in items {
            if sender.send(item).is_err() {
                break;
            }
        }
    })?;
    Ok(receiver)
}

/// Threads of a reader's own, so many as the current pool has. A caller that waits in that pool can then not
/// keep it from working.
pub fn pool(most: usize) -> io::Result<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(rayon::current_num_threads().min(most))
        .thread_name(|thread| format!("tables {thread}"))
        .build()
        .map_err(io::Error::other)
}
