//! Lists of records in one vertex buffer, a region for each draw.

use bytemuck::Pod;

/// Records of a block: regions are whole blocks. Also the leaves in a row of textures.
pub const BLOCK_SIZE: u32 = 256;
/// Unchanged records between two changed ones that are uploaded with them.
const NEAR: u32 = 32;

/// The records of one draw.
pub struct Region<T> {
    pub items: Vec<T>,
    /// The owner of each item: a number of the caller's.
    pub owners: Vec<u32>,
    /// Index of the first item in the buffer: a multiple of [`BLOCK_SIZE`].
    pub first: u32,
    /// Room, records: a multiple of [`BLOCK_SIZE`].
    pub capacity: u32,
    changed: Vec<u32>,
}

impl<T: Pod> Region<T> {
    pub fn push(&mut self, item: T, owner: u32) -> u32 {
        let at = self.items.len() as u32;
        self.items.push(item);
        self.owners.push(owner);
        self.changed.push(at);
        at
    }

    /// Removes an item; the last takes its index. Returns the owner of the one that moved.
    pub fn swap_remove(&mut self, at: u32) -> Option<u32> {
        self.items.swap_remove(at as usize);
        self.owners.swap_remove(at as usize);
        let moved = self.owners.get(at as usize).copied();
        if moved.is_some() {
            self.changed.push(at);
        }
        moved
    }

    /// Its items as a range of the buffer.
    pub fn range(&self) -> std::ops::Range<u32> {
        self.first..self.first + self.items.len() as u32
    }
}

/// Regions that grow, and their buffer.
pub struct Arena<T> {
    pub regions: Vec<Region<T>>,
    pub buffer: wgpu::Buffer,
    label: &'static str,
}

/// What an upload did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Upload {
    Nothing,
    Some,
    /// Regions moved: the buffer is another one.
    All,
}

impl<T: Pod> Arena<T> {
    pub fn new(device: &wgpu::Device, label: &'static str, regions: usize) -> Self {
        let mut regions: Vec<Region<T>> = (0..regions)
            .map(|_| Region {
                items: Vec::new(),
                owners: Vec::new(),
                first: 0,
                capacity: 0,
                changed: Vec::new(),
            })
            .collect();
        let total = layout(&mut regions);
        Self { buffer: buffer::<T>(device, label, total), regions, label }
    }

    pub fn clear(&mut self) {
        for region in &mut self.regions {
            region.items.clear();
            region.owners.clear();
            region.changed.clear();
        }
    }

    pub fn len(&self) -> u64 {
        self.regions.iter().map(|r| r.items.len() as u64).sum()
    }

    /// Room of all regions, records.
    pub fn capacity(&self) -> u32 {
        self.regions.iter().map(|r| r.capacity).sum()
    }

    /// Brings the buffer up to date. `changed_run` gets each range of the buffer that has other records now, unless
    /// regions moved.
    pub fn upload(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        mut changed_run: impl FnMut(std::ops::Range<u32>),
    ) -> Upload {
        if self.regions.iter().any(|r| r.items.len() as u32 > r.capacity) {
            let total = layout(&mut self.regions);
            self.buffer = buffer::<T>(device, self.label, total);
            for region in &mut self.regions {
                region.changed.clear();
                write(queue, &self.buffer, region, 0..region.items.len() as u32);
            }
            return Upload::All;
        }
        let mut done = Upload::Nothing;
        for region in &mut self.regions {
            let mut changed = std::mem::take(&mut region.changed);
            let count = region.items.len() as u32;
            changed.sort_unstable();
            changed.retain(|&i| i < count);
            for run in changed.chunk_by(|a, b| b - a <= 1) {
                changed_run(region.first + run[0]..region.first + run[run.len() - 1] + 1);
            }
            let mut i = 0;
            while i < changed.len() {
                let start = changed[i];
                let mut end = start + 1;
                while i < changed.len() && changed[i] <= end + NEAR {
                    end = changed[i] + 1;
                    i += 1;
                }
                write(queue, &self.buffer, region, start..end);
                done = Upload::Some;
            }
            changed.clear();
            region.changed = changed;
        }
        done
    }
}

fn write<T: Pod>(
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    region: &Region<T>,
    range: std::ops::Range<u32>,
) {
    let items = &region.items[range.start as usize..range.end as usize];
    if !items.is_empty() {
        let at = u64::from(region.first + range.start) * size_of::<T>() as u64;
        queue.write_buffer(buffer, at, bytemuck::cast_slice(items));
    }
}

/// Grows every region that is full, to half as much again; returns the records of all.
fn layout<T>(regions: &mut [Region<T>]) -> u32 {
    let mut next = 0;
    for region in regions {
        let wanted = region.items.len() as u32;
        if wanted > region.capacity || region.capacity == 0 {
            region.capacity = (wanted + wanted / 2).next_multiple_of(BLOCK_SIZE).max(BLOCK_SIZE);
        }
        region.first = next;
        next += region.capacity;
    }
    next.max(BLOCK_SIZE)
}

fn buffer<T>(device: &wgpu::Device, label: &str, records: u32) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: u64::from(records) * size_of::<T>() as u64,
        usage: wgpu::BufferUsages::VERTEX
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the buffer has for each region.
    fn uploaded(device: &wgpu::Device, queue: &wgpu::Queue, arena: &Arena<u32>) -> Vec<Vec<u32>> {
        let bytes = windfall_testing::read(device, queue, &arena.buffer);
        let words: &[u32] = bytemuck::cast_slice(&bytes);
        let of =
            |range: std::ops::Range<u32>| words[range.start as usize..range.end as usize].to_vec();
        arena.regions.iter().map(|region| of(region.range())).collect()
    }

    #[test]
    fn the_buffer_has_what_the_regions_have() {
        let (device, queue) = windfall_testing::device();
        let mut arena = Arena::<u32>::new(&device, "words", 3);
        assert_eq!(arena.upload(&device, &queue, |_| ()), Upload::Nothing);
        let mut changed = Vec::new();
        for step in 0..40u32 {
            for i in 0..20 * step {
                let region = (i % 3) as usize;
                arena.regions[region].push(1000 * step + i, i);
            }
            // From the front, so that others move; the owner of the moved one is told.
            for region in &mut arena.regions {
                for at in 0..(region.items.len() as u32 / 3).min(step) {
                    let last = region.owners[region.owners.len() - 1];
                    assert_eq!(region.swap_remove(at), Some(last));
                    assert_eq!(region.owners[at as usize], last);
                }
            }
            changed.clear();
            let before = arena.buffer.clone();
            let upload = arena.upload(&device, &queue, |run| changed.push(run));
            assert_eq!(upload == Upload::All, arena.buffer != before, "step {step}");
            let items: Vec<Vec<u32>> = arena.regions.iter().map(|r| r.items.clone()).collect();
            assert_eq!(uploaded(&device, &queue, &arena), items, "step {step}");
            assert!(arena.regions.iter().all(|r| r.first % BLOCK_SIZE == 0));
            assert_eq!(arena.len(), items.iter().map(|i| i.len() as u64).sum::<u64>());
        }
        // One record in the middle: one run of one record.
        arena.regions[1].swap_remove(5);
        let first = arena.regions[1].first;
        changed.clear();
        assert_eq!(arena.upload(&device, &queue, |run| changed.push(run)), Upload::Some);
        assert!(changed.len() == 1 && changed[0] == (first + 5..first + 6), "{changed:?}");
        // The last one: nothing moves.
        let last = arena.regions[2].items.len() as u32 - 1;
        assert_eq!(arena.regions[2].swap_remove(last), None);
        assert_eq!(arena.upload(&device, &queue, |_| ()), Upload::Nothing);
        arena.clear();
        assert_eq!(arena.len(), 0);
        assert!(arena.capacity() >= 3 * BLOCK_SIZE);
    }
}
